"""The log of the HTTP server's library, without the unreadable part of a request, which may contain a token."""

import logging
from typing import Final

from aiohttp.http_exceptions import HttpProcessingError

from openrois.observability.logs import Tally

__all__ = ["HTTP_LOG"]

HTTP_LOG: Final = logging.getLogger(__name__)
"""For `AppRunner(logger=...)`: the library's own logs every line that it cannot read, and a traceback for each."""

HTTP_LOG.setLevel(logging.INFO)

_unreadable = Tally(logging.getLogger(f"{__name__}.unreadable"), "requests that cannot be read")
_failed = Tally(logging.getLogger(f"{__name__}.failed"), "requests that failed inside", logging.ERROR)


def _is_worth_a_line(record: logging.LogRecord) -> bool:
    """Tell whether a record is about something else than an unreadable request, and count those.

    A traceback is logged at 1, 2, 4, 8 ... unreadable requests: a client may send them for ever.
    """
    error = record.exc_info[1] if record.exc_info else None
    if error is None:
        return True
    if isinstance(error, HttpProcessingError):
        _unreadable.note(type(error).__name__)
        return False
    _failed.note(type(error).__name__)
    return _failed.count.bit_count() == 1


HTTP_LOG.addFilter(_is_worth_a_line)
