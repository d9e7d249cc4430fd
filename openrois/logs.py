"""Where log lines go: standard error, one line each."""

import logging

__all__ = ["set_up_logging"]


def set_up_logging(*, verbose: bool) -> None:
    """Log warnings of everything and this project's news; `verbose` adds its details."""
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(levelname).1s %(name)s: %(message)s")
    for name in ("openrois", "openrois_signaling", "openrois_streaming", "openrois_avatar"):
        logging.getLogger(name).setLevel(logging.DEBUG if verbose else logging.INFO)
