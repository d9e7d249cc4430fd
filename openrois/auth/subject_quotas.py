"""Quotas of one subject, over all of its connections: connections, sessions and streams. Pure."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from typing import Any, Final, NamedTuple, Protocol

from openrois.errors import OutOfResources

__all__ = [
    "CONNECTIONS_OF_SUBJECT",
    "SESSIONS_OF_SUBJECT",
    "STREAMS_OF_SUBJECT",
    "QuotaSession",
    "SubjectQuotas",
    "Usage",
]

CONNECTIONS_OF_SUBJECT: Final = 256
"""Applications at a time that show tokens of one subject; one more is answered 429."""

SESSIONS_OF_SUBJECT: Final = 512
"""Their sessions: those of connections, and those whose connection was lost and may be resumed.

Twice as many as connections, so that all of them can come back at once."""

STREAMS_OF_SUBJECT: Final = 32
"""Streams of all of them; less than an adapter has places for applications that may not bind."""


class Usage(NamedTuple):
    """What one subject has, or may have.

    Attributes:
        connections: its applications that are connected.
        sessions: theirs, and those that may be resumed.
        streams: of all of them.
    """

    connections: int = 0
    sessions: int = 0
    streams: int = 0


_NOTHING: Final = Usage()


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

    @property
    def is_relayed(self) -> bool:
        """Whether its application is connected to another gateway, which counts the session."""
        ...


class SubjectQuotas:
    """Connections, sessions and streams of each subject at this gateway.

    Args:
        connections: how many one subject may have.
        sessions: how many, those whose connection was lost included.
        streams: how many.

    Attributes:
        most: what one subject may have.
        absent: gives the sessions whose connection was lost and may be resumed.
        elsewhere: returns what a subject has at other gateways.
        on_change: called with the name of a subject that has more or less than before; absent sessions aside.
    """

    def __init__(
        self,
        connections: int = CONNECTIONS_OF_SUBJECT,
        sessions: int = SESSIONS_OF_SUBJECT,
        streams: int = STREAMS_OF_SUBJECT,
    ) -> None:
        self.most = Usage(connections, sessions, streams)
        self._connections: Counter[str] = Counter()
        self._sessions: dict[str, set[QuotaSession]] = {}
        self.absent: Callable[[], Iterable[Any]] = tuple
        self.elsewhere: Callable[[str], Usage] = lambda _name: _NOTHING
        self.on_change: Callable[[str], None] = lambda _name: None

    def names(self) -> Iterator[str]:
        """Return the subjects that have something here; absent sessions aside."""
        yield from self._connections
        yield from self._sessions.keys() - self._connections.keys()

    def __contains__(self, name: str) -> bool:
        return name in self._connections or name in self._sessions

    def count_absent(self) -> Counter[str]:
        """Return how many sessions of each subject may be resumed here."""
        return Counter(session.quota_name for session in self.absent() if not session.is_relayed)

    def usage(self, name: str, absent: int) -> Usage:
        """Return what a subject has here, with so many absent sessions."""
        connections = self._connections[name]
        return Usage(connections, connections + absent, self._streams_of(name))

    @property
    def most_connections(self) -> int:
        """Largest number of connections that a subject has."""
        return max(self._connections.values(), default=0)

    @property
    def most_sessions(self) -> int:
        """Largest number of sessions that a subject has."""
        return max((self._connections + self.count_absent()).values(), default=0)

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
        elsewhere, connections = self.elsewhere(name), self._connections[name]
        _require_less(connections, elsewhere.connections, self.most.connections, "connections")
        absent = sum(session.quota_name == name and not session.is_relayed for session in self.absent())
        _require_less(connections + absent, elsewhere.sessions, self.most.sessions, "sessions")
        self._connections[name] += 1
        self.on_change(name)
        try:
            yield
        finally:
            self._connections[name] -= 1
            if not self._connections[name]:
                del self._connections[name]
            self.on_change(name)

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
            self.on_change(name)

    def note_streams(self, session: QuotaSession) -> None:
        """Note that a session has more or fewer streams than before."""
        self.on_change(session.quota_name)

    def require_stream(self, session: QuotaSession) -> None:
        """Do nothing where the subject of a session may have one more stream.

        Raises:
            OutOfResources: it has as many as it may have.
        """
        name = session.quota_name
        _require_less(self._streams_of(name), self.elsewhere(name).streams, self.most.streams, "streams")

    def _streams_of(self, name: str) -> int:
        return sum(len(session.streams) + session.connecting for session in self._sessions.get(name, ()))


def _require_less(here: int, elsewhere: int, most: int, what: str) -> None:
    if here + elsewhere >= most:
        where = f"; at other gateways there are {elsewhere}" if elsewhere else ""
        raise OutOfResources(f"one subject has at most {most} {what}{where}")
