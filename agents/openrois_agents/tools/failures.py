"""What an agent is told when a tool fails: the reason that the gateway or body gave, and which kind it is."""

import logging
from typing import Final

from openrois.client import BadParameter, ConnectionFailed, ConnectionLost, RoISError, RpcError, TimedOut, Unsupported
from openrois.extras import MissingExtra

__all__ = ["FAILURES", "failure"]

_log = logging.getLogger(__name__)

FAILURES: Final = (ConnectionFailed, ConnectionLost, RoISError, RpcError, TimeoutError)
"""What a call raises where the gateway or a body refuses, or does not answer."""

MAX_REASON: Final = 1_000
"""Characters of a reason."""


def failure(tool: str, error: Exception) -> tuple[str, str]:
    """Return the kind of a failure, and one sentence with it. What no tool should raise is logged, and not told.

    Args:
        tool: which failed.
        error: what it raised.
    """
    match error:
        case RoISError():
            kind, reason = type(error).__name__, str(error)
        case ConnectionFailed() | ConnectionLost():
            kind, reason = ConnectionLost.__name__, str(error)
        case TimeoutError():
            kind, reason = TimedOut.__name__, str(error) or "no answer came in time"
        case MissingExtra() | RpcError():
            kind, reason = Unsupported.__name__, str(error)
        case ValueError():
            # The libraries for media say so where a component has no pictures.
            kind, reason = BadParameter.__name__, str(error)
        case _:
            _log.error("the tool %s failed", tool, exc_info=error)
            kind, reason = "Error", f"{tool} failed for a reason that the log of openrois mcp has"
    return kind, f"{kind}: {''.join(each if each.isprintable() else ' ' for each in reason)[:MAX_REASON]}"
