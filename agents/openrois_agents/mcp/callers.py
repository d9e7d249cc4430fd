"""Callers over HTTP: each has a session of its own at the gateway, with its own token."""

import asyncio
import hashlib
import logging
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Final, Self

from openrois.client import Client, ConnectionFailed
from openrois_agents.mcp.guard import Refused
from openrois_agents.mcp.token_claims import expiry_of, rights_of
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

__all__ = ["Caller", "Callers", "MakeClient"]

_log = logging.getLogger(__name__)

MAX_CALLERS: Final = 64
"""Callers at a time; one that is idle and holds no body makes room for the next."""

MAX_TOKENS: Final = 512
"""Tokens that are known to have been let in; the one that was used the longest ago makes room for the newest."""

VERIFIED_FOR: Final = 60.0
"""Seconds after which the gateway is asked again whether it lets a token in."""

MakeClient = Callable[[Callable[[], str] | None], Client]
"""Returns a client that shows what a function returns as its token; None to show none."""


@dataclass(slots=True)
class Caller:
    """A caller.

    Attributes:
        key: the same for all tokens of one subject with the same rights.
        session: its session.
        token: the one that lasts longest of those that it has shown.
        expires: when that ends.
    """

    key: str
    session: Session
    token: str
    expires: float

    def note_token(self, token: str) -> None:
        """Keep a token where it lasts longer."""
        if (expires := expiry_of(token) or 0.0) > self.expires:
            self.token, self.expires = token, expires


@dataclass(frozen=True, slots=True)
class _Admitted:
    key: str
    at: float


class Callers:
    """Finds the session of the caller that shows a token.

    A token is shown to the gateway before it is believed, and again after a while. One subject has one session, also
    when it shows a newer token. Where the gateway lets in who shows none, it judges no token: then each token is a
    caller by itself.

    Args:
        make_client: returns clients of the gateway.
        settings: of the tools.
        clock: monotonic seconds.
        now: seconds of the epoch.
    """

    def __init__(
        self,
        make_client: MakeClient,
        settings: ToolSettings,
        clock: Callable[[], float] = time.monotonic,
        now: Callable[[], float] = time.time,
    ) -> None:
        self._make_client = make_client
        self._settings = settings
        self._clock = clock
        self._now = now
        self._turn = asyncio.Lock()
        self._judges: bool | None = None
        self._admitted: OrderedDict[str, _Admitted] = OrderedDict()
        self._callers: dict[str, Caller] = {}

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End every session, which gives every body back."""
        callers, self._callers = self._callers, {}
        leaving = (caller.session.__aexit__(None, None, None) for caller in callers.values())
        for failure in await asyncio.gather(*leaving, return_exceptions=True):
            if isinstance(failure, Exception):
                _log.error("a session did not end well", exc_info=failure)

    def __len__(self) -> int:
        return len(self._callers)

    async def find_session(self, request: Any) -> Session:
        """Return the session that the guard has found for a request."""
        session: Session = request.scope["openrois.caller"].session
        return session

    async def admit(self, token: str) -> Caller:
        """Return the caller that shows a token.

        Raises:
            Refused: the token has ended, the gateway does not let it in or is not there, or there are too many callers.
        """
        expires = expiry_of(token)
        if expires is not None and expires <= self._now():
            raise Refused(401, "the token has ended")
        digest = hashlib.sha256(token.encode()).hexdigest()
        if (key := self._known(digest)) is not None and (caller := self._callers.get(key)) is not None:
            return caller
        async with self._turn:
            key = self._known(digest) or await self._verified(token, digest)
            caller = self._callers.get(key)
            if caller is None:
                await self._make_room()
                caller = self._new_caller(key, token, expires or 0.0)
                await caller.session.__aenter__()
                self._callers[key] = caller
            caller.note_token(token)
            return caller

    def _known(self, digest: str) -> str | None:
        """Return the key of the caller whose token the gateway has let in lately."""
        known = self._admitted.get(digest)
        if known is None or self._clock() - known.at >= VERIFIED_FOR:
            return None
        self._admitted.move_to_end(digest)
        return known.key

    async def _verified(self, token: str, digest: str) -> str:
        """Return the key of the caller, after the gateway has let the token in."""
        self._admitted.pop(digest, None)
        await self._show(lambda: token)
        rights = rights_of(token)
        key = rights if rights and await self._gateway_judges() else digest
        self._admitted[digest] = _Admitted(key, self._clock())
        if len(self._admitted) > MAX_TOKENS:
            self._admitted.popitem(last=False)
        return key

    async def _gateway_judges(self) -> bool:
        """Tell whether the gateway judges tokens: it does where it does not let in who shows none."""
        if self._judges is None:
            try:
                await self._show(None)
            except Refused as refused:
                if refused.status != 401:
                    raise
                self._judges = True
            else:
                self._judges = False
        return self._judges

    async def _show(self, token: Callable[[], str] | None) -> None:
        """Show a token to the gateway.

        Raises:
            Refused: it does not let that in, or is not there.
        """
        client = self._make_client(token)
        try:
            await client.connect()
        except ConnectionFailed as error:
            if error.final:
                raise Refused(401, "the gateway does not let this token in") from None
            raise Refused(503, f"the gateway cannot be asked: {error}") from None
        finally:
            await client.close()

    def _new_caller(self, key: str, token: str, expires: float) -> Caller:
        session = Session(lambda: self._make_client(lambda: caller.token), self._settings)
        caller = Caller(key, session, token, expires)
        return caller

    async def _make_room(self) -> None:
        """End the session that is idle for the longest, where there are as many as may be.

        Raises:
            Refused: each of them is used, or holds a body.
        """
        if len(self._callers) < MAX_CALLERS:
            return
        idle = [each for each in self._callers.values() if each.session.idle > 0 and each.session.held is None]
        if not idle:
            raise Refused(503, f"there are {MAX_CALLERS} callers already: try again later")
        oldest = max(idle, key=lambda caller: caller.session.idle)
        del self._callers[oldest.key]
        await oldest.session.__aexit__(None, None, None)
