"""Where log lines go: standard error, one line each; and how often the same thing may be said."""

import logging

__all__ = ["Tally", "set_up_logging"]


def set_up_logging(*, verbose: bool) -> None:
    """Log warnings of everything and this project's news; `verbose` adds its details."""
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(levelname).1s %(name)s: %(message)s")
    for name in ("openrois", "openrois_signaling", "openrois_streaming", "openrois_avatar"):
        logging.getLogger(name).setLevel(logging.DEBUG if verbose else logging.INFO)


class Tally:
    """Counts what somebody else can cause at will, and logs it ever more seldom: at 1, 2, 4, 8 ... occurrences.

    Args:
        log: the logger of the module that counts.
        what: what is counted, in the plural.
        level: of the log lines.
    """

    def __init__(self, log: logging.Logger, what: str, level: int = logging.INFO) -> None:
        self._log = log
        self._what = what
        self._level = level
        self.count = 0

    def note(self, detail: str = "") -> None:
        """Count one more; `detail` says what this one was."""
        self.count += 1
        if self.count.bit_count() == 1:
            self._log.log(self._level, "%s: %d so far%s", self._what, self.count, f", now {detail}" if detail else "")
