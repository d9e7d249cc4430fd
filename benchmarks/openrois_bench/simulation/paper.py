"""The paper model of a cluster as formulas: what a load needs, from what each kind of work costs. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Final

__all__ = [
    "CONNECTIONS",
    "MEBIBYTE",
    "MEDIA",
    "MESSAGES",
    "TOGETHER",
    "Costs",
    "Load",
    "Media",
    "Streams",
    "Wire",
    "Work",
    "cpu",
    "gateways",
    "memory",
    "over_sockets",
    "streams",
]

MEBIBYTE: Final = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Work:
    """How much of each kind there is, or what one of each kind costs.

    Attributes:
        attach: bodies that come: connection, handshake, profile, and their place in the tree.
        session: applications that come: connection, hello, and the bodies that they show.
        leave: applications that go.
        query: questions to a body and their answers.
        pipelined_query: those that an application asks several of before the first answer.
        command: commands: bind, execute, completed, release.
        subscription: subscriptions, from their beginning to their end.
        event: events that a gateway receives of an adapter.
        delivery: events that it sends to an application.
        burst_event: events that it receives of an adapter, many at once.
        burst_delivery: those that it sends to an application.
        stream: streams, with the signaling of a peer connection, from their beginning to their end.
        sign: signs of life to a body that moves.
        change: notifications of a changed directory to an application.
        fault: sessions that are asked whether the loss of an adapter concerns them: each one at its gateway.
        hop: messages that a front gateway passes on to the owner of a body, or back.
    """

    attach: float = 0.0
    session: float = 0.0
    leave: float = 0.0
    query: float = 0.0
    pipelined_query: float = 0.0
    command: float = 0.0
    subscription: float = 0.0
    event: float = 0.0
    delivery: float = 0.0
    burst_event: float = 0.0
    burst_delivery: float = 0.0
    stream: float = 0.0
    sign: float = 0.0
    change: float = 0.0
    fault: float = 0.0
    hop: float = 0.0

    def parts(self) -> Mapping[str, float]:
        """Return every kind by its name."""
        return {each.name: float(getattr(self, each.name)) for each in fields(self)}


@dataclass(frozen=True, slots=True)
class Costs:
    """What a gateway takes.

    Attributes:
        work: seconds of a processor for one of each kind.
        body: bytes of memory of a body.
        session: bytes of memory of an application's session.
        detail: bytes of memory of an event that was sent to an application, which may ask for its details.
        connection: bytes of memory of a connection, with its buffers.
    """

    work: Work
    body: float
    session: float
    detail: float
    connection: float


@dataclass(frozen=True, slots=True)
class Load:
    """What stands before the gateways.

    Attributes:
        bodies: how many.
        applications: that are connected.
        a_second: how much of each kind of work there is in a second, for all gateways together.
        details: events for whose details one application may ask, at most.
    """

    bodies: int
    applications: int
    a_second: Work
    details: float = 0.0


def cpu(costs: Work, amount: Work) -> float:
    """Return the processor seconds that an amount of work takes: the sum over all kinds of number x cost."""
    each = costs.parts()
    return sum(number * each[name] for name, number in amount.parts().items())


def memory(costs: Costs, load: Load) -> float:
    """Return the bytes that all gateways need: bodies, sessions, their connections, and the details that are kept."""
    session = costs.session + load.details * costs.detail
    return load.bodies * (costs.body + costs.connection) + load.applications * (session + costs.connection)


def gateways(costs: Costs, load: Load, busy: float, bytes_each: float) -> int:
    """Return how many gateways a load needs.

    Args:
        costs: what one of each kind takes.
        load: what there is.
        busy: the share of one processor that a gateway may take: its event loop has no more than one.
        bytes_each: the memory of one gateway.
    """
    by_cpu = cpu(costs.work, load.a_second) / busy
    by_memory = memory(costs, load) / bytes_each
    return max(1, _up(by_cpu), _up(by_memory))


def _up(number: float) -> int:
    return int(-(-number // 1))


MESSAGES: Final = Work(
    attach=5,
    session=6,
    query=4,
    pipelined_query=4,
    command=12,
    subscription=8,
    event=1,
    delivery=1,
    burst_event=1,
    burst_delivery=1,
    stream=32,
    sign=1,
    change=1,
)
"""Messages that a gateway reads and writes for one of each kind."""

TOGETHER: Final = frozenset({"pipelined_query", "burst_event", "burst_delivery"})
"""Kinds whose messages come several at once, and share calls of the system and turns of the loop."""

CONNECTIONS: Final = Work(attach=1, session=1)
"""Connections that are opened for one of each kind."""


@dataclass(frozen=True, slots=True)
class Wire:
    """What sockets add to the work of a gateway, in seconds of a processor.

    Attributes:
        message: for each message that is read or written: the system's calls, the WebSocket frame, turns of the loop.
        together: for each message of kinds in `TOGETHER`.
        connection: for each connection: TCP, the HTTP request, its token.
    """

    message: float
    together: float
    connection: float


def over_sockets(costs: Work, wire: Wire) -> Work:
    """Return what one of each kind costs a gateway with sockets, of what it costs without."""
    messages, connections = MESSAGES.parts(), CONNECTIONS.parts()

    def added(name: str) -> float:
        message = wire.together if name in TOGETHER else wire.message
        return messages[name] * message + connections[name] * wire.connection

    return Work(**{name: cost + added(name) for name, cost in costs.parts().items()})


@dataclass(frozen=True, slots=True)
class Media:
    """What one viewer of one stream takes.

    Attributes:
        bits: bits a second.
        direct: share of a processor of the adapter that sends, for each further viewer.
        viewers: that one event loop carries.
        relayed: share of viewers that need TURN.
    """

    bits: float
    direct: float
    viewers: int
    relayed: float


MEDIA: Final = Media(bits=2.5e6, direct=0.0037, viewers=200, relayed=0.15)
"""720p30, measured with `openrois_bench.streams.peers` on a quiet machine; the share of relayed viewers is assumed."""


@dataclass(frozen=True, slots=True)
class Streams:
    """What viewers of streams need.

    Attributes:
        cores: processors of all senders.
        egress: bits a second of all senders.
        relayed: bits a second that pass TURN, in one direction.
        uplink: bits a second that leave one avatar.
        needs_sfu: whether one avatar has more viewers than its uplink or its event loop carries.
    """

    cores: float
    egress: float
    relayed: float
    uplink: float
    needs_sfu: bool


def streams(media: Media, avatars: int, viewers: int, uplink: float) -> Streams:
    """Return what viewers need that are spread evenly over avatars.

    Args:
        media: what one viewer takes.
        avatars: how many there are.
        viewers: how many there are.
        uplink: bits a second that one avatar can send.
    """
    each = viewers / avatars
    egress = viewers * media.bits
    return Streams(
        cores=viewers * media.direct,
        egress=egress,
        relayed=egress * media.relayed,
        uplink=each * media.bits,
        needs_sfu=each > min(media.viewers, uplink / media.bits),
    )
