"""Quotas of one subject at a gateway, over all of its connections: connections, sessions and streams. Pure."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from typing import Any, Final, Protocol

from openrois.errors import OutOfResources

__all__ = ["CONNECTIONS_OF_SUBJECT", "SESSIONS_OF_SUBJECT", "STREAMS_OF_SUBJECT", "QuotaSession", "SubjectQuotas"]

CONNECTIONS_OF_SUBJECT: Final = 256
"""Applications at a time that show tokens of one subject; one more is answered 429."""

SESSIONS_OF_SUBJECT: Final = 512
"""Their sessions: those of connections, and those whose connection was lost and may be resumed.

Twice as many as connections, so that all of them can come back at once."""

STREAMS_OF_SUBJECT: Final = 32
"""Streams of all of them; less than an adapter has places for applications that may not bind."""


class QuotaSession(Protocol):
    """The session of an application, as quotas see it."""

    @property
    def quota_name(self) -> str:
        """The name that it counts against."""
        ...

    @property
    def streams(self) -> Sized:
        """The ids of its streams."""
        ...

    @property
    def connecting(self) -> int:
        """Number of streams that are being connected."""
        ...


class SubjectQuotas:
    """Connections, sessions and streams of each subject.

    Args:
        connections: how many one subject may have.
        sessions: how many, those whose connection was lost included.
        streams: how many.

    Attributes:
        absent: gives the sessions whose connection was lost and may be resumed.
    """

    def __init__(
        self,
        connections: int = CONNECTIONS_OF_SUBJECT,
        sessions: int = SESSIONS_OF_SUBJECT,
        streams: int = STREAMS_OF_SUBJECT,
    ) -> None:
        self._connections_limit = connections
        self._sessions_limit = sessions
        self._streams_limit = streams
        self._connections: Counter[str] = Counter()
        self._sessions: dict[str, set[QuotaSession]] = {}
        self.absent: Callable[[], Iterable[Any]] = tuple

    @property
    def most_connections(self) -> int:
        """Largest number of connections that a subject has."""
        return max(self._connections.values(), default=0)

    @property
    def most_sessions(self) -> int:
        """Largest number of sessions that a subject has."""
        absent = Counter(session.quota_name for session in self.absent())
        return max((self._connections + absent).values(), default=0)

    @property
    def most_streams(self) -> int:
        """Largest number of streams that a subject has."""
        return max(map(self._streams_of, self._sessions), default=0)

    @contextmanager
    def connected(self, name: str) -> Iterator[None]:
        """Count a connection while the block runs.

        Args:
            name: the name that it counts against.

        Raises:
            OutOfResources: the subject has as many connections, or sessions, as it may have.
        """
        if self._connections[name] >= self._connections_limit:
            raise OutOfResources(f"one subject has at most {self._connections_limit} connections")
        absent = sum(session.quota_name == name for session in self.absent())
        if self._connections[name] + absent >= self._sessions_limit:
            raise OutOfResources(f"one subject has at most {self._sessions_limit} sessions")
        self._connections[name] += 1
        try:
            yield
        finally:
            self._connections[name] -= 1
            if not self._connections[name]:
                del self._connections[name]

    @contextmanager
    def serving(self, session: QuotaSession) -> Iterator[None]:
        """Count the streams of a session while the block runs."""
        name = session.quota_name
        sessions = self._sessions.setdefault(name, set())
        sessions.add(session)
        try:
            yield
        finally:
            sessions.discard(session)
            if not sessions:
                del self._sessions[name]

    def require_stream(self, session: QuotaSession) -> None:
        """Do nothing where the subject of a session may have one more stream.

        Raises:
            OutOfResources: it has as many as it may have.
        """
        if self._streams_of(session.quota_name) >= self._streams_limit:
            raise OutOfResources(f"one subject has at most {self._streams_limit} streams")

    def _streams_of(self, name: str) -> int:
        return sum(len(session.streams) + session.connecting for session in self._sessions.get(name, ()))
