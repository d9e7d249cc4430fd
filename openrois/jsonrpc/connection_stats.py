"""Statistics of a gateway's connections: open ones are read, and the sums of closed ones are kept."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from openrois.jsonrpc.latencies import Latencies
from openrois.jsonrpc.session import RpcSession

__all__ = ["ConnectionStats", "Seen"]


@dataclass(slots=True)
class Seen:
    """The connections of one kind at one moment, and from `requests` on those that ended, too.

    Attributes:
        connections: how many live.
        opened: how many there were.
        running: requests that are being served.
        unanswered: our own requests that wait for their answers.
        waiting: messages that wait to be sent.
        most_waiting: on the connection where most do.
        subscriptions: how many there are.
        requests: how many came.
        refused: how many of them were answered with a reason: refused, or failed in RoIS terms.
        crowded: how many of them because there were too many.
        urgent: how many requests passed others.
        queued: requests that wait to be served.
        failed: how many handlers raised what they must not raise.
        violations: malformed messages.
        dropped: events that were dropped because the other side reads too slowly.
        overflows: connections that were cut because the other side does not read.
    """

    connections: int = 0
    opened: int = 0
    running: int = 0
    unanswered: int = 0
    waiting: int = 0
    most_waiting: int = 0
    subscriptions: int = 0
    requests: int = 0
    refused: int = 0
    crowded: int = 0
    urgent: int = 0
    queued: int = 0
    failed: int = 0
    violations: int = 0
    dropped: int = 0
    overflows: int = 0

    def add_sums(self, session: RpcSession) -> None:
        """Add the sums of a connection."""
        self.requests += session.requests
        self.refused += session.refused
        self.crowded += session.request_queue.refused
        self.urgent += session.request_queue.urgent
        self.failed += session.failed
        self.violations += session.violations
        self.dropped += session.outbox.dropped
        self.overflows += session.overflows

    def add_state(self, session: RpcSession, subscriptions: int) -> None:
        """Add the present state of a connection."""
        self.connections += 1
        self.running += session.running
        self.queued += len(session.request_queue)
        self.unanswered += session.unanswered
        self.waiting += len(session.outbox)
        self.most_waiting = max(self.most_waiting, len(session.outbox))
        self.subscriptions += subscriptions


class ConnectionStats:
    """The connections of all kinds.

    Attributes:
        latencies: of the requests of applications.
        call_latencies: of our calls to adapters.
        turned_away: how many connections were refused, by reason; the reasons are this program's own words.
        cut: how many connections were cut because the other side did not behave, by reason.
        closed: how many connections ended with each code of the WebSocket protocol.
    """

    def __init__(self) -> None:
        self._living: dict[str, dict[int, tuple[RpcSession, Callable[[], int]]]] = {}
        """By their kind and their identity: of many one leaves in no more time than of few."""
        self._ended: dict[str, Seen] = {}
        self.latencies = Latencies()
        self.call_latencies = Latencies()
        self.turned_away: dict[str, int] = {}
        self.cut: dict[str, int] = {}
        self.closed: dict[int, int] = {}

    @contextmanager
    def counted(self, kind: str, session: RpcSession, subscriptions: Callable[[], int] = int) -> Iterator[None]:
        """Count a connection while the block runs, and add its sums when it ends.

        Args:
            kind: `application` or `adapter`.
            session: the connection.
            subscriptions: tells how many it has.
        """
        living = self._living.setdefault(kind, {})
        ended = self._ended.setdefault(kind, Seen())
        ended.opened += 1
        living[id(session)] = session, subscriptions
        try:
            yield
        finally:
            del living[id(session)]
            ended.add_sums(session)
            code = session.closed.code if session.closed is not None else 1006
            self.closed[code] = self.closed.get(code, 0) + 1

    def sessions(self, kind: str) -> tuple[RpcSession, ...]:
        """Return the connections of one kind that live."""
        return tuple(session for session, _ in self._living.get(kind, {}).values())

    def turn_away(self, reason: str) -> None:
        """Count a connection that was refused."""
        self.turned_away[reason] = self.turned_away.get(reason, 0) + 1

    def cut_off(self, reason: str) -> None:
        """Count a connection that was cut."""
        self.cut[reason] = self.cut.get(reason, 0) + 1

    def seen(self, kind: str) -> Seen:
        """Return the state of the connections of one kind."""
        now = replace(self._ended.get(kind, Seen()))
        for session, subscriptions in self._living.get(kind, {}).values():
            now.add_sums(session)
            now.add_state(session, subscriptions())
        return now
