"""Closes connections when their token expires or is revoked, unless it was renewed."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final, Protocol

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.auth.refusal import Refusal
from openrois.observability.audit import Audit

__all__ = ["TOKEN_ENDED", "TokenExpiries", "TokenExpiry"]

_log = logging.getLogger(__name__)

TOKEN_ENDED: Final = 4401
"""The close code of a connection whose token has expired or was revoked."""

CHECK_INTERVAL: Final = 1.0
"""Seconds between two checks of every connection."""

WARNING_TIME: Final = 60.0
"""Seconds before its end at which a connection is warned."""

_SAID: Final = {Refusal.EXPIRED: "the token has expired", Refusal.REVOKED: "the token was revoked"}


class Closing(Protocol):
    """A connection that can be closed."""

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Close it."""
        ...


@dataclass(eq=False)
class TokenExpiry:
    """The principal of one connection, until its token ends.

    Attributes:
        principal: whose connection it is now.
        on_principal: called with another principal in its place; with one that may do nothing when it is over.
        on_expiring: called with the seconds that are left; returns whether the other side was notified.
        warned: whether it was notified.
        is_over: whether it has ended, and cannot be made longer any more.
        address: where it comes from; empty where it comes over no network.
    """

    principal: Principal
    on_principal: Callable[[Principal], None] = lambda _principal: None
    on_expiring: Callable[[float], bool] = lambda _seconds: False
    warned: bool = field(default=False, repr=False)
    is_over: bool = field(default=False, repr=False)
    address: str = ""

    def replace(self, principal: Principal) -> None:
        """Replace the principal by another one."""
        self.principal = principal
        self.warned = False
        self.on_principal(principal)


class TokenExpiries:
    """Every connection, checked for the end of its token.

    Args:
        clock: epoch seconds.
        is_revoked: whether a principal's token does not hold any more.
        audit: records connections that end.
        tasks: owns what closes them.
        sleep: waits for some seconds between two checks.
    """

    def __init__(
        self,
        clock: Callable[[], float],
        is_revoked: Callable[[Principal], bool],
        audit: Audit,
        tasks: TaskScope,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._clock = clock
        self._is_revoked = is_revoked
        self._audit = audit
        self._tasks = tasks
        self._sleep = sleep
        self._connections: dict[TokenExpiry, Closing] = {}
        self.ended = 0

    @contextmanager
    def holding(self, expiry: TokenExpiry, connection: Closing) -> Iterator[None]:
        """Watch a connection while the block runs."""
        self._connections[expiry] = connection
        try:
            yield
        finally:
            self._connections.pop(expiry, None)

    async def watch(self) -> None:
        """Check for ever."""
        while True:
            await self._sleep(CHECK_INTERVAL)
            self.check_tokens()

    def check_tokens(self) -> None:
        """End every connection whose token has ended, and warn those whose soon will."""
        now = self._clock()
        for expiry in tuple(self._connections):
            reason = self._why_over(expiry.principal, now)
            if reason is not None:
                self._end_connection(expiry, reason)
                continue
            expires = expiry.principal.expires
            if expires is not None and expires - now <= WARNING_TIME and not expiry.warned:
                expiry.warned = expiry.on_expiring(expires - now)

    def _why_over(self, principal: Principal, now: float) -> Refusal | None:
        if principal.expires is not None and principal.expires <= now:
            return Refusal.EXPIRED
        return Refusal.REVOKED if self._is_revoked(principal) else None

    def _end_connection(self, expiry: TokenExpiry, reason: Refusal) -> None:
        former, connection = expiry.principal, self._connections.pop(expiry)
        self.ended += 1
        self._audit.refused(former, "session", "", reason.value)
        _log.info("the session of %s ends: %s", former.subject, _SAID[reason])
        # From here on nothing more is done for it, also while it is being closed.
        expiry.is_over = True
        self._tasks.start(connection.close(TOKEN_ENDED, _SAID[reason]))
        try:
            expiry.replace(Principal(former.subject, frozenset(), ()))
        except Exception:
            # Whatever went wrong in one session, the others end in their time, too.
            _log.exception("the session of %s could not be stripped of what it holds", former.subject)
