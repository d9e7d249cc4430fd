"""Destination of log lines: standard error or a file, one line each; and rates of repeated messages."""

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Final, Literal

from openrois.observability.line_writer import LineWriter
from openrois.observability.log_lines import JsonLine, Redaction, TextLine

__all__ = ["LogFile", "Tally", "set_up_logging"]

_OURS: Final = (
    "openrois",
    "openrois_signaling",
    "openrois_streaming",
    "openrois_media",
    "openrois_body",
    "openrois_avatar",
    "openrois_robots",
    "openrois_agents",
    "openrois_demo",
)
"""Packages whose information is logged."""


def set_up_logging(
    *,
    verbose: bool,
    form: Literal["text", "json"] = "text",
    file: Path | None = None,
    secrets: Iterable[str] = (),
) -> None:
    """Log warnings of all libraries and this project's information; handlers that the process has already stay.

    Args:
        verbose: log this project's details, too.
        form: one line for people, or one JSON object.
        file: where to append them; standard error unless given.
        secrets: what may stand in no line.

    Raises:
        OSError: the file cannot be written.
    """
    handler = logging.StreamHandler() if file is None else LogFile(file)
    redact = Redaction(secrets)
    handler.setFormatter(JsonLine(redact) if form == "json" else TextLine(redact))
    logging.basicConfig(level=logging.WARNING, handlers=[handler])
    for name in _OURS:
        logging.getLogger(name).setLevel(logging.DEBUG if verbose else logging.INFO)


class LogFile(logging.Handler):
    """Lines in a file that may be rotated; a thread writes them, so that a slow disk delays nothing.

    Raises:
        OSError: the file cannot be written.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._writer = LineWriter[str](path, str, lambda lost: f"{lost} lines were lost here")
        self._writer.__enter__()

    def emit(self, record: logging.LogRecord) -> None:
        """Queue a record."""
        self._writer.put(self.format(record), dispensable=record.levelno < logging.WARNING)

    def close(self) -> None:
        """Write what waits, for at most some seconds."""
        if self._writer.is_running:
            self._writer.__exit__(None, None, None)
        super().close()


class Tally:
    """Counts what clients can cause at will, and logs it ever more seldom: at 1, 2, 4, 8 ... occurrences.

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
        """Count one more; `detail` describes this one."""
        self.count += 1
        if self.count.bit_count() == 1:
            self._log.log(self._level, "%s: %d so far%s", self._what, self.count, f", now {detail}" if detail else "")
