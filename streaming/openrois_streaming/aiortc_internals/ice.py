"""The only place that touches names of aioice that are not public: sockets, candidates and connectivity checks.

What is reached for, and why nothing public does it:

* `RTCIceTransport._connection` is the aioice connection, and its `get_component_candidates` opens sockets on any port
  of every interface and waits for STUN and TURN servers. Here sockets are opened as the settings say, and servers are
  asked later.
* `RTCIceTransport._recv` is what DTLS and SRTP wait in for the next datagram: it suspends them in time.
* `StunProtocol` receives every datagram; a `Gate` stands in front of it. `check_state` and `check_incoming` tell which
  sources prove themselves, `respond_error` answers those that do not, and `_queue` is what waits for DTLS and SRTP.
* `sort_check_list` comes whenever there are more pairs to check; they may be so many that sorting takes seconds.
* `TurnTransport.close` goes on with a task of its own, which is cancelled where a TURN server does not answer.
* `connect` begins to ask for consent as its last step, for ever where `close` was called meanwhile.
* `_nominated` is the pair that is sent over; when its other end is silent, a pair that has proven itself takes over.
"""

import asyncio
import functools
import logging
import socket
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import Any, Final

from aioice import Candidate, ice, stun
from aioice.candidate import candidate_foundation, candidate_priority
from aioice.turn import UDP_SOCKET_BUFFER_SIZE, TurnTransport
from aiortc.rtcicetransport import RTCIceTransport

from openrois_streaming.network.admission import Admission, Traffic, Verdict, media_traffic
from openrois_streaming.network.datagrams import KINDS, Kind, StunClass, stun_class, transaction_of
from openrois_streaming.network.guard import (
    PAIRS_LIMIT,
    QUEUE_LIMIT,
    REPLIES_AT_ONCE,
    REPLIES_PER_SECOND,
    Allowance,
    Gate,
    GuardFigures,
    Source,
)
from openrois_streaming.network.servers import TurnServer
from openrois_streaming.network.turns import Ingress, TurnTaking
from openrois_streaming.tasks import OwnedTasks

PROOF_TRIES: Final = 3
"""How often a source is asked to prove itself after ICE is done, 0.5, 1.5 and 3.5 s after the first time."""

RELEASE_TIMEOUT: Final = 1.0
"""Seconds that a TURN server has to let go of a relay."""

_UNAUTHENTICATED: Final = (400, 401)
_STATE: Final = ice.CandidatePair.State

_log = logging.getLogger(__name__)


def local_candidate(kind: str, host: str, port: int, *, base: str, related: tuple[str, int] | None = None) -> Candidate:
    """A candidate of this end; `base` is the address it is sent from (RFC 8445 section 5.1.1.3)."""
    candidate = Candidate(
        candidate_foundation(kind, "udp", base), 1, "udp", candidate_priority(1, kind), host, port, kind
    )
    if related is not None:
        candidate.related_address, candidate.related_port = related
    return candidate


def stop_consent_when_closed(connection: ice.Connection) -> None:
    """Have `connection` ask for no consent where it was closed as its path was found. To be called before it connects.

    aioice goes on 20 ms after `close` at the latest, and would ask for ever.
    """
    connect = connection.connect

    async def connect_unless_closed() -> None:
        await connect()
        consent = connection._query_consent_task
        if connection._closing and consent is not None:
            consent.cancel()
            await asyncio.wait({consent})
            raise ConnectionError("the connection was closed while its path was found")

    connection.connect = connect_unless_closed  # type: ignore[method-assign]


class GuardedProtocol(ice.StunProtocol):
    """One socket of an ICE agent, behind its gate."""

    def __init__(self, agent: "IceAgent") -> None:
        super().__init__(agent.connection)
        self._agent = agent
        self._figures = agent.figures
        self.gate = Gate(agent.permits, agent.figures)
        self._is_closing = False

    def send_stun(self, message: stun.Message, addr: tuple[str, int]) -> None:
        """Send a message, unless the socket is closed, which a check that waits for its answer does not know."""
        if not self._is_closing:
            super().send_stun(message, addr)

    def datagram_received(self, data: bytes | str, addr: tuple[Any, ...]) -> None:
        """Let pass what may: STUN is read, DTLS and SRTP of proven sources go on."""
        assert isinstance(data, bytes)
        kind = KINDS[data[0]] if data else Kind.OTHER
        source = (addr[0], addr[1])
        if kind is Kind.STUN:
            self._stun_received(data, source)
        elif kind is Kind.OTHER:
            self._figures.unknown += 1
        elif self.gate.passes(data, source):
            self._agent.deliver(data)

    async def close(self) -> None:
        """Close the socket; a relay that does not let go is left to its server, where it ends within minutes."""
        self._is_closing = True
        try:
            async with asyncio.timeout(RELEASE_TIMEOUT):
                await super().close()
        except TimeoutError:
            relay: Any = self.transport
            # A socket of this machine was closed at once: this process itself stood still.
            if isinstance(relay, TurnTransport):
                _log.info("a TURN server does not answer to the end of a relay")
                await self._drop(relay)

    async def _drop(self, relay: Any) -> None:
        """Ask no more: aioice would do so for half a minute, with the socket open."""
        relay._TurnTransport__close_task.cancel()
        await asyncio.wait({relay._TurnTransport__close_task})
        relay._TurnTransport__inner_protocol.transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        """The socket is closed, or the connection to the TURN server is."""
        self._is_closing = True
        self._agent.lost_way(self)
        super().connection_lost(exc)

    def _stun_received(self, data: bytes, source: Source) -> None:
        kind = stun_class(data)
        if kind is None:
            self._figures.malformed += 1
        elif kind in (StunClass.SUCCESS, StunClass.ERROR) and transaction_of(data) not in self.transactions:
            self._figures.unasked += 1
        elif kind is StunClass.REQUEST and not self._agent.is_meant(data):
            if self._agent.may_reply:
                self._take_in(data, source)
            else:
                self._figures.unauthenticated += 1
        elif kind is not StunClass.INDICATION:
            # To verify one takes long: where the turn is spent it waits for the next.
            self._agent.check(functools.partial(self._take_in, data, source), len(data))

    def _take_in(self, data: bytes, source: Source) -> None:
        try:
            self._read(stun.parse_message(data), source)
        except Exception:  # the parser and what follows it raise whatever hostile bytes make of them
            self._figures.malformed += 1

    def _read(self, message: stun.Message, source: Source) -> None:
        if message.message_class is not stun.Class.REQUEST:
            transaction = self.transactions.get(message.transaction_id)
            if transaction is not None:  # it may have ended while the answer waited for its turn
                transaction.response_received(message, source)
            return
        early = self.receiver._early_checks
        self.receiver.request_received(message, source, self)
        if early and early[-1][1:] == (source, self):
            # It is authentic, but no answer is there yet. Its sender may go on at once, for it has a reply.
            self.gate.expect(source)


class Checks:
    """Connectivity checks beside those that aioice makes to find its first path. To be closed.

    Args:
        connection: whose credentials and paths they are about.
        admit: called for each source that proves itself.
    """

    def __init__(self, connection: ice.Connection, admit: Callable[[GuardedProtocol, Source], None]) -> None:
        self._connection = connection
        self._admit = admit
        self._proving: set[tuple[GuardedProtocol, Source]] = set()
        self._tasks = OwnedTasks("ice", self._failed)

    async def answers(self, *, tries: int = 1) -> bool:
        """Whether the other end answers on the path that is sent over, within 0.5 s; within 1.5 s with two `tries`.

        Every ICE agent must answer it (RFC 8445 section 7.3), also when it has no media to send.
        """
        pair = self._connection._nominated.get(1)
        return pair is not None and await self._check(pair, tries=tries)

    def prove(self, protocol: GuardedProtocol, source: Source) -> None:
        """Ask `source` to prove itself, unless it is being asked."""
        if (protocol, source) not in self._proving and not self._connection._closing:
            self._proving.add((protocol, source))
            self._tasks.start(self._try_to_prove(protocol, source), "check")

    async def settled(self) -> None:
        """Wait until no source is being asked."""
        await self._tasks.finished()

    async def aclose(self) -> None:
        """Ask nobody any more."""
        await self._tasks.aclose()

    async def _try_to_prove(self, protocol: GuardedProtocol, source: Source) -> None:
        remote = Candidate("0", 1, "udp", candidate_priority(1, "prflx"), source[0], source[1], "prflx")
        pair = ice.CandidatePair(protocol, remote)
        try:
            if not await self._check(pair, tries=PROOF_TRIES):
                protocol.gate.forget(source)
                return
            self._admit(protocol, source)
            # A path that appears while the present one is silent has come in its place, behind a NAT for example.
            if not await self.answers() and await self._check(pair, tries=PROOF_TRIES, nominate=True):
                self._connection._nominated[1] = pair
        finally:
            self._proving.discard((protocol, source))

    async def _check(self, pair: ice.CandidatePair, *, tries: int, nominate: bool = False) -> bool:
        connection = self._connection
        if connection.remote_password is None:
            return False
        try:
            _, seen_from = await pair.protocol.request(
                connection.build_request(pair, nominate=nominate),
                pair.remote_addr,
                integrity_key=connection.remote_password.encode(),
                retransmissions=tries - 1,
            )
        except (stun.TransactionError, OSError):
            return False
        return seen_from == pair.remote_addr

    def _failed(self, error: BaseException) -> None:
        _log.error("a connectivity check failed inside", exc_info=error)


def _close_opened(opening: asyncio.Future[tuple[asyncio.DatagramTransport, GuardedProtocol]]) -> None:
    if not opening.cancelled() and opening.exception() is None:
        opening.result()[0].close()


class IceAgent:
    """An aioice connection with guarded sockets. To be made before the first description is.

    Args:
        transport: whose connection it is.
        gather: finds the candidates of the first description, and may raise.
        permits: says whether an address and port may be sent to.
        figures: where is counted what does not pass.
        ingress: what it has in common with others.
    """

    def __init__(
        self,
        transport: RTCIceTransport,
        gather: Callable[[], Awaitable[list[Candidate]]],
        permits: Callable[[str, int], bool],
        figures: GuardFigures,
        ingress: Ingress,
    ) -> None:
        self.connection = connection = transport._connection
        self.has_path = True
        """False once the way that was found is gone for a reason on this side."""
        self.permits = permits
        self.figures = figures
        self._turns = ingress.turns
        self.admission = Admission(ingress.total)
        self._gather = gather
        self._name = f"{connection.local_username}:".encode()
        transport._recv = TurnTaking(ingress.turns, connection.recv).receive
        self._replies = Allowance(time.monotonic, REPLIES_AT_ONCE, REPLIES_PER_SECOND)
        self.checks = Checks(connection, self._admit)
        self._aioice_check_state = connection.check_state
        self._aioice_check_incoming = connection.check_incoming
        self._aioice_respond_error = connection.respond_error
        connection.get_component_candidates = self._get_component_candidates  # type: ignore[method-assign]
        connection.check_state = self._check_state  # type: ignore[method-assign]
        connection.check_incoming = self._check_incoming  # type: ignore[method-assign, assignment]
        connection.respond_error = self._respond_error  # type: ignore[method-assign]
        self._aioice_sort_check_list = connection.sort_check_list
        connection.sort_check_list = self._sort_check_list  # type: ignore[method-assign]
        self._told_of_pairs = False
        stop_consent_when_closed(connection)
        self._aioice_close = connection.close
        connection.close = self._close  # type: ignore[method-assign]

    @property
    def is_done(self) -> bool:
        """Whether a path was found, or none can be found any more."""
        return self.connection._check_list_done

    def lost_way(self, protocol: GuardedProtocol) -> None:
        """A socket is there no more. A way over a relay goes with the connection to its TURN server."""
        self.has_path &= all(pair.protocol is not protocol for pair in self.connection._nominated.values())

    @property
    def waiting(self) -> int:
        """How many datagrams wait for DTLS and SRTP."""
        return self.connection._queue.qsize()

    @property
    def paths(self) -> tuple[tuple[Candidate, str, int], ...]:
        """The path that is sent over, if there is one: the local candidate, and the other end's address and port."""
        return tuple((pair.local_candidate, *pair.remote_addr) for pair in self.connection._nominated.values())

    def adopt(self, protocol: GuardedProtocol) -> None:
        """Use a socket from now on; it is closed with the connection."""
        self.connection._protocols.append(protocol)

    async def open_host(self, address: str, ports: Sequence[int]) -> Candidate:
        """Open a socket on the first of `ports` that is free.

        Raises:
            OSError: none is, or the address is not this machine's.
        """
        loop = asyncio.get_running_loop()
        for port in ports:
            opening = asyncio.ensure_future(
                loop.create_datagram_endpoint(functools.partial(GuardedProtocol, self), local_addr=(address, port))
            )
            try:
                transport, protocol = await asyncio.shield(opening)
                break
            except asyncio.CancelledError:
                # uvloop leaves a socket open that is given up while it is opened.
                opening.add_done_callback(_close_opened)
                raise
            except OSError:
                if port == ports[-1]:
                    raise
        self.adopt(protocol)
        opened = transport.get_extra_info("socket")
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, UDP_SOCKET_BUFFER_SIZE)
        host, bound = transport.get_extra_info("sockname")[:2]
        protocol.local_candidate = local_candidate("host", host, bound, base=host)
        return protocol.local_candidate

    async def ask_stun(self, host: Candidate, server: tuple[str, int]) -> tuple[str, int]:
        """Under which address and port a STUN server sees the socket of `host`.

        Raises:
            aioice.stun.TransactionError: it does not say.
        """
        protocol = next(each for each in self.connection._protocols if each.local_candidate is host)
        request = stun.Message(message_method=stun.Method.BINDING, message_class=stun.Class.REQUEST)
        response, _ = await protocol.request(request, server)
        try:
            address, port = response.attributes["XOR-MAPPED-ADDRESS"]
        except KeyError:
            raise stun.TransactionFailed(response) from None
        return str(address), int(port)

    async def allocate(self, server: TurnServer, *, hide: bool) -> Candidate:
        """Have a TURN server relay, and pair its address with all candidates of the other end.

        Args:
            server: the server.
            hide: whether nobody is told by which address this machine reached it.

        Raises:
            aioice.stun.TransactionError, OSError: it does not.
        """
        candidate, protocol = await ice.relayed_candidate(
            component=1,
            hide_related_address=hide,
            protocol_factory=lambda: GuardedProtocol(self),
            turn_server=(server.host, server.port),
            turn_username=server.username,
            turn_password=server.credential,
            turn_ssl=server.tls,
            turn_transport=server.transport,
        )
        connection = self.connection
        if connection._closing or self.is_done:
            await protocol.close()  # nobody needs it any more; the server has others to serve
            raise ConnectionError("the relay came too late to be of use")
        assert isinstance(protocol, GuardedProtocol), "it was made here"
        self.adopt(protocol)
        for remote in connection._remote_candidates:
            connection._pair_remote_candidate(remote)
        connection.sort_check_list()
        return candidate

    def add(self, candidate: Candidate) -> None:
        """From now on `candidate` stands in every description."""
        self.connection._local_candidates.append(candidate)

    def is_meant(self, request: bytes) -> bool:
        """Whether a connectivity check may be for this agent: it names it (RFC 8445 section 7.2.2)."""
        return self._name in request

    @property
    def may_reply(self) -> bool:
        """Whether one more request without credentials would be answered."""
        return self._replies.has()

    def check(self, work: Callable[[], None], octets: int) -> None:
        """Have a connectivity check of so many bytes taken in by `work`, now or in its turn, if it is admitted."""
        if self._admits(Traffic.CHECK, octets) and not self._turns.do(work):
            self.figures.overflow += 1

    def _admits(self, traffic: Traffic, octets: int) -> bool:
        """Whether one more datagram is admitted; counts it otherwise."""
        match self.admission.judge(traffic, octets):
            case Verdict.PEER_LIMIT:
                self.figures.peer_limit += 1
            case Verdict.TOTAL_LIMIT:
                self.figures.total_limit += 1
            case Verdict.ADMITTED:
                return True
        return False

    def deliver(self, data: bytes) -> None:
        """Hand DTLS or SRTP of a proven source over."""
        if self.connection._queue.qsize() >= QUEUE_LIMIT:
            self.figures.overflow += 1
        elif self._admits(media_traffic(data), len(data)):
            self.connection.data_received(data, 1)

    async def _get_component_candidates(
        self, component: int, addresses: list[str], timeout: float = 0
    ) -> list[Candidate]:
        return await self._gather()

    async def _close(self) -> None:
        await self.checks.aclose()  # before their sockets are closed
        await self._aioice_close()

    def _check_state(self, pair: ice.CandidatePair, state: ice.CandidatePair.State) -> None:
        self._aioice_check_state(pair, state)
        protocol = pair.protocol
        assert isinstance(protocol, GuardedProtocol), "every socket here is guarded"
        if state is _STATE.IN_PROGRESS:
            protocol.gate.expect(pair.remote_addr)
        elif state is _STATE.SUCCEEDED:
            self._admit(protocol, pair.remote_addr)
            asyncio.get_running_loop().call_soon(self._prove_others)
        elif state is _STATE.FAILED:
            protocol.gate.forget(pair.remote_addr)

    def _check_incoming(self, message: stun.Message, addr: Source, protocol: GuardedProtocol) -> None:
        """An authentic check came in."""
        if "PRIORITY" not in message.attributes:
            self.figures.malformed += 1
        elif not protocol.gate.expect(addr):
            pass
        elif not self.is_done:
            # It may be of a pair that is new, and may not be left out then.
            if self._limit_pairs(PAIRS_LIMIT - 1):
                self._aioice_check_incoming(message, addr, protocol)
            else:
                self.figures.forbidden += 1
        elif addr not in protocol.gate.proven:
            self.checks.prove(protocol, addr)

    def _respond_error(
        self, request: stun.Message, addr: Source, protocol: ice.StunProtocol, error_code: tuple[int, str]
    ) -> None:
        if error_code[0] in _UNAUTHENTICATED:
            self.figures.unauthenticated += 1
            if not self._replies.admits():
                return
        self._aioice_respond_error(request, addr, protocol, error_code)

    def _sort_check_list(self) -> None:
        self._aioice_sort_check_list()
        self._limit_pairs(PAIRS_LIMIT)

    def _limit_pairs(self, limit: int) -> bool:
        """Leave out pairs of the lowest priority that are not being checked; whether no more than `limit` are left."""
        pairs = self.connection._check_list
        for pair in reversed(pairs[:]):
            if len(pairs) <= limit:
                return True
            if pair.task is None and pair.state in (_STATE.FROZEN, _STATE.WAITING):
                pairs.remove(pair)
                self._tell_of_pairs()
        return len(pairs) <= limit

    def _tell_of_pairs(self) -> None:
        if not self._told_of_pairs:
            self._told_of_pairs = True
            told = "a peer connection has more than %d candidate pairs: those of the lowest priority are not checked"
            _log.info(f"{told} (RFC 8445)", PAIRS_LIMIT)

    def _admit(self, protocol: GuardedProtocol, source: Source) -> None:
        for data in protocol.gate.admit(source):
            self.deliver(data)

    def _prove_others(self) -> None:
        """With the first path aioice gives up its other checks; the other end may use another one all the same."""
        if self.is_done:
            for protocol in self.connection._protocols:
                if isinstance(protocol, GuardedProtocol):
                    for source in protocol.gate.expected:
                        self.checks.prove(protocol, source)
