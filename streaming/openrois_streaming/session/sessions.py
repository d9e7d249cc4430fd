"""Stream sessions of all applications of one engine."""

import asyncio
import logging
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Self

from openrois_signaling.messages import Direction

from openrois_streaming.aiortc_internals.trial import self_test
from openrois_streaming.errors import TooManySessions, UnknownPeer, UnknownStream
from openrois_streaming.network.session_limits import SessionLimits
from openrois_streaming.session.session import StreamSession
from openrois_streaming.tasks import OwnedTasks, Task

_log = logging.getLogger(__name__)


class StreamSessions:
    """Sessions by application; no application reaches the streams of another.

    A session without streams keeps its place only while no other application needs it; so does one whose offers were
    not answered in time. To be used inside `async with`, which first tests the installed aiortc.

    Args:
        make: makes the session of a client id.
        rules: limits on the sessions.

    Attributes:
        rules: limits on the sessions.
        displaced: number of sessions that lost their place because their offers were not answered.

    Raises:
        UnsupportedLibrary: (on entering) the installed aiortc is not supported.
    """

    def __init__(self, make: Callable[[str], StreamSession], rules: SessionLimits | None = None) -> None:
        self._make = make
        self.rules = rules or SessionLimits()
        self.displaced = 0
        self._sessions: dict[str, StreamSession] = {}
        self._may_bind: dict[str, bool] = {}
        """Of each application with a session, whether it may bind."""
        self._tasks = OwnedTasks("sessions", _failed)
        self._held: dict[str, tuple[Direction, ...]] = {}

    async def __aenter__(self) -> Self:
        await self_test()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose("the engine stops")

    def __len__(self) -> int:
        """Return how many sessions have a peer connection."""
        return sum(not session.is_over for session in self._sessions.values())

    def __iter__(self) -> Iterator[StreamSession]:
        return iter(tuple(self._sessions.values()))

    @property
    def unanswered(self) -> int:
        """Number of sessions none of whose offers was ever answered."""
        return len(self._unanswered())

    def open(self, client_id: str, *, may_bind: bool = True) -> StreamSession:
        """Return the session of a client; a new one if it has none.

        Args:
            client_id: id of the client.
            may_bind: whether it may bind components now; places are kept for clients that may.

        Raises:
            TooManySessions: the limit is reached.
        """
        session = self._sessions.get(client_id)
        if session is None:
            self._make_room(may_bind)
            session = self._sessions[client_id] = self._make(client_id)
            for component_ref, directions in self._held.items():
                session.hold(component_ref, *directions)
        # Its role may have changed since its first stream.
        self._may_bind[client_id] = may_bind
        return session

    def with_stream(self, client_id: str, stream_id: str) -> StreamSession:
        """Return the session of `client_id`, which has the stream `stream_id`.

        Raises:
            UnknownStream: it has not; whether another client has is not revealed.
        """
        session = self._sessions.get(client_id)
        if session is None or stream_id not in session.stream_ids:
            raise UnknownStream("there is no such stream")
        return session

    def with_peer(self, client_id: str, peer_id: str) -> StreamSession:
        """Return the session of `client_id`, which has the peer connection `peer_id`.

        Raises:
            UnknownPeer: it has not; whether another client has is not revealed.
        """
        session = self._sessions.get(client_id)
        if session is None or peer_id not in session.peer_ids:
            raise UnknownPeer("there is no such peer connection")
        return session

    def hold(self, component_ref: str, *directions: Direction) -> None:
        """Suspend the present and later streams of a component, or those of `directions` alone."""
        self._held[component_ref] = directions
        for session in self._sessions.values():
            session.hold(component_ref, *directions)

    def release(self, component_ref: str) -> None:
        """Resume the streams that `hold` has suspended; those that their applications have suspended stay so."""
        self._held.pop(component_ref, None)
        for session in self._sessions.values():
            session.release(component_ref)

    async def close(self, client_id: str, reason: str) -> None:
        """End the session of a client that is gone, if it has one. It goes on closing when the caller is cancelled."""
        if client_id in self._sessions:
            await asyncio.shield(self._close_session(client_id, reason))

    async def aclose(self, reason: str) -> None:
        """End all sessions, at the same time, and wait until they are closed, for a few seconds at most."""
        for client_id in tuple(self._sessions):
            self._close_session(client_id, reason)
        await self._tasks.finished()

    def _make_room(self, may_bind: bool) -> None:
        if self.rules.has_room(self._may_bind.values(), may_bind):
            return
        for client_id, session in tuple(self._sessions.items()):
            if not session.stream_ids:
                self._close_session(client_id, "nothing is left to play")
        if self.rules.has_room(self._may_bind.values(), may_bind):
            return
        late = self.rules.displaced(self._may_bind, self._unanswered(), may_bind)
        if late is None:
            full = f"all {self.rules.applications} places for applications are in use"
            raise TooManySessions(f"{full}: try again later, or set a higher --applications")
        self.displaced += 1
        self._close_session(late, "the offer was not answered in time, and another application needs the place")

    def _unanswered(self) -> dict[str, float]:
        waits = ((client_id, session.unanswered_for()) for client_id, session in self._sessions.items())
        return {client_id: seconds for client_id, seconds in waits if seconds is not None}

    def _close_session(self, client_id: str, reason: str) -> Task[None]:
        del self._may_bind[client_id]
        return self._tasks.start(self._sessions.pop(client_id).close(reason), f"close {client_id}")


def _failed(error: BaseException) -> None:
    _log.error("a session did not end cleanly", exc_info=error)
