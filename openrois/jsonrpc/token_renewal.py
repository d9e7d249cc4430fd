"""Renewal of the token on an open connection, when the gateway notifies that the present one ends soon."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.jsonrpc.session import NotificationHandler, RpcError, RpcSession, SessionClosed
from openrois.transport.credentials import Credentials
from openrois.types.access import AuthExpiringNotification

__all__ = ["renew_token"]

_log = logging.getLogger(__name__)

PAUSE: Final = 10.0
"""Seconds until the newest token is shown again, where it was not a new one yet."""

ATTEMPTS: Final = 6

_ENOUGH: Final = 60


def renew_token(
    session: RpcSession,
    credentials: Credentials,
    tasks: TaskScope,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
) -> dict[str, NotificationHandler]:
    """Return the handler of the notice that a token ends soon; none where there is no other token to show.

    Args:
        session: the connection.
        credentials: where the newest token is.
        tasks: owns the asking.
        sleep: waits for some seconds.
    """
    if not callable(credentials.token):
        return {}

    async def renew() -> None:
        for attempt in range(ATTEMPTS):
            if attempt:
                await sleep(PAUSE)
            try:
                answer = await session.call("openrois.auth.refresh", {"token": credentials.newest()})
            except SessionClosed:
                return
            except (ValueError, TimeoutError, RpcError) as error:
                _log.warning("no new token: %s", error)
                continue
            if _is_enough(answer):
                _log.info("the gateway has accepted a new token")
                return
        _log.warning("the token ends, and no newer one was found: the gateway will close the connection")

    def expiring(_params: dict[str, Any]) -> None:
        tasks.start(renew())

    return {AuthExpiringNotification.method: expiring}


def _is_enough(answer: object) -> bool:
    """Tell whether the token that was shown was taken, and lasts longer than the one before."""
    if not isinstance(answer, dict) or answer.get("return_code") != "OK":
        return False
    seconds = answer.get("seconds")
    return isinstance(seconds, int) and seconds > _ENOUGH
