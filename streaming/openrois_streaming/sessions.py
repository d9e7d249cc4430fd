"""All applications that play something from this engine."""

import asyncio
import logging
from collections.abc import Callable
from types import TracebackType
from typing import Self

from openrois_streaming.aiortc_seams import self_test
from openrois_streaming.errors import TooManySessions, UnknownPeer, UnknownStream
from openrois_streaming.session import StreamSession

SESSIONS_LIMIT = 64
"""Applications at once. Each costs about 1 % of a core for each stream that plays."""

_log = logging.getLogger(__name__)


class StreamSessions:
    """Which application has which session; nobody reaches the streams of another.

    To be used inside `async with`, which first tries whether the installed aiortc is one that can be used. `make` makes
    the session of a client id.

    Raises:
        UnsupportedLibrary: (on entering) it is not.
    """

    def __init__(self, make: Callable[[str], StreamSession], limit: int = SESSIONS_LIMIT) -> None:
        self._make = make
        self._limit = limit
        self._sessions: dict[str, StreamSession] = {}

    async def __aenter__(self) -> Self:
        await self_test()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose("the engine stops")

    def __len__(self) -> int:
        return len(self._sessions)

    def open(self, client_id: str) -> StreamSession:
        """The session of a client; a new one if it has none.

        Raises:
            TooManySessions: it would be one too many.
        """
        session = self._sessions.get(client_id)
        if session is None:
            if len(self._sessions) >= self._limit:
                raise TooManySessions(f"{self._limit} applications are served already")
            session = self._sessions[client_id] = self._make(client_id)
        return session

    def with_stream(self, client_id: str, stream_id: str) -> StreamSession:
        """The session of `client_id`, which has the stream `stream_id`.

        Raises:
            UnknownStream: it has not; whether somebody else has is not told.
        """
        session = self._sessions.get(client_id)
        if session is None or stream_id not in session.stream_ids:
            raise UnknownStream("there is no such stream")
        return session

    def with_peer(self, client_id: str, peer_id: str) -> StreamSession:
        """The session of `client_id`, which has the peer connection `peer_id`.

        Raises:
            UnknownPeer: it has not; whether somebody else has is not told.
        """
        session = self._sessions.get(client_id)
        if session is None or peer_id not in session.peer_ids:
            raise UnknownPeer("there is no such peer connection")
        return session

    async def close(self, client_id: str, reason: str) -> None:
        """End the session of a client that is gone; unknown ones are fine."""
        session = self._sessions.pop(client_id, None)
        if session is not None:
            await session.close(reason)

    async def aclose(self, reason: str) -> None:
        """End all sessions, at the same time."""
        sessions, self._sessions = self._sessions, {}
        ends = await asyncio.gather(*(session.close(reason) for session in sessions.values()), return_exceptions=True)
        for end in ends:
            if isinstance(end, BaseException):
                _log.error("a session did not end cleanly", exc_info=end)
