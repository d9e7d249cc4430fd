"""The log of the HTTP server's library: without what it could not read of a request, for a token may stand in it."""

import logging
from typing import Final

from aiohttp.http_exceptions import HttpProcessingError

from openrois.observability.logs import Tally

__all__ = ["HTTP_LOG"]

HTTP_LOG: Final = logging.getLogger(__name__)
"""For `AppRunner(logger=...)`: the library's own shows every line that it could not read, and a traceback for each."""

HTTP_LOG.setLevel(logging.INFO)

_unreadable = Tally(logging.getLogger(f"{__name__}.unreadable"), "requests that cannot be read")
_failed = Tally(logging.getLogger(f"{__name__}.failed"), "requests that failed inside", logging.ERROR)


def _is_worth_a_line(record: logging.LogRecord) -> bool:
    """Tell whether a record is about something else than a request that could not be read, and count that.

    A traceback stands at 1, 2, 4, 8 ... requests that failed: who finds one that does may send it for ever.
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
