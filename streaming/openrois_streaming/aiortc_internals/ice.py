"""ICE agent: guarded sockets, candidates and connectivity checks, by private names of aioice.

Private names in use, and why no public one does it:

* `RTCIceTransport._connection` is the aioice connection, and its `get_component_candidates` opens sockets on any port
  of every interface and waits for STUN and TURN servers. Here sockets are opened as the settings say, and servers are
  asked later.
* `RTCIceTransport._recv` is where DTLS and SRTP await the next datagram; ours suspends them in time.
* `StunProtocol` receives every datagram; a `Gate` is in front of it. `check_state` and `check_incoming` show which
sources authenticate, `respond_error` answers those that do not, and `_queue` holds datagrams for DTLS and SRTP.
* `sort_check_list` is called for every new pair; there may be so many that sorting takes seconds.
* `TurnTransport.close` goes on in a task of its own, which is cancelled if a TURN server does not answer.
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

from openrois_streaming.aiortc_internals.ice_checks import Checks, stop_consent_when_closed
from openrois_streaming.network.admission import Admission, Traffic, Verdict, media_traffic
from openrois_streaming.network.guard import (
    KINDS,
    PAIRS_LIMIT,
    QUEUE_LIMIT,
    REPLIES_AT_ONCE,
    REPLIES_PER_SECOND,
    Allowance,
    Gate,
    GuardFigures,
    Kind,
    Source,
    StunClass,
    stun_class,
    transaction_of,
)
from openrois_streaming.network.servers import TurnServer
from openrois_streaming.network.turns import Ingress, TurnTaking

RELEASE_TIMEOUT: Final = 1.0
"""Seconds that a TURN server has to release a relay."""

_UNAUTHENTICATED: Final = (400, 401)
_STATE: Final = ice.CandidatePair.State

_log = logging.getLogger(__name__)


def local_candidate(kind: str, host: str, port: int, *, base: str, related: tuple[str, int] | None = None) -> Candidate:
    """Return a candidate of this end; `base` is the address it is sent from (RFC 8445 section 5.1.1.3)."""
    candidate = Candidate(
        candidate_foundation(kind, "udp", base), 1, "udp", candidate_priority(1, kind), host, port, kind
    )
    if related is not None:
        candidate.related_address, candidate.related_port = related
    return candidate


class GuardedProtocol(ice.StunProtocol):
    """Socket of an ICE agent, behind its gate."""

    def __init__(self, agent: "IceAgent") -> None:
        super().__init__(agent.connection)
        self._agent = agent
        self._figures = agent.figures
        self.gate = Gate(agent.permits, agent.figures)
        self._is_closing = False

    def send_stun(self, message: stun.Message, addr: tuple[str, int]) -> None:
        """Send a message, unless the socket is closed, which a pending check does not know."""
        if not self._is_closing:
            super().send_stun(message, addr)

    def datagram_received(self, data: bytes | str, addr: tuple[Any, ...]) -> None:
        """Read STUN, pass DTLS and SRTP of proven sources on, and drop all else."""
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
        """Close the socket; a relay that its server does not release ends there within minutes."""
        self._is_closing = True
        try:
            async with asyncio.timeout(RELEASE_TIMEOUT):
                await super().close()
        except TimeoutError:
            relay: Any = self.transport
            # A local socket was closed at once, so this process itself stood still.
            if isinstance(relay, TurnTransport):
                _log.info("a TURN server does not confirm the release of a relay")
                await self._drop(relay)

    async def _drop(self, relay: Any) -> None:
        """Stop asking the server: aioice would do so for half a minute, with the socket open."""
        relay._TurnTransport__close_task.cancel()
        await asyncio.wait({relay._TurnTransport__close_task})
        relay._TurnTransport__inner_protocol.transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        """Note that the socket, or the connection to the TURN server, is closed."""
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
                self._process_stun(data, source)
            else:
                self._figures.unauthenticated += 1
        elif kind is not StunClass.INDICATION:
            # Verification takes long: if the turn is spent it waits for the next.
            self._agent.check(functools.partial(self._process_stun, data, source), len(data))

    def _process_stun(self, data: bytes, source: Source) -> None:
        try:
            self._read(stun.parse_message(data), source)
        except Exception:  # the parser and its callers raise anything on hostile bytes
            self._figures.malformed += 1

    def _read(self, message: stun.Message, source: Source) -> None:
        if message.message_class is not stun.Class.REQUEST:
            transaction = self.transactions.get(message.transaction_id)
            if transaction is not None:  # it may have ended while the answer waited for a turn
                transaction.response_received(message, source)
            return
        early = self.receiver._early_checks
        self.receiver.request_received(message, source, self)
        if early and early[-1][1:] == (source, self):
            # The check is authentic, but there is no SDP answer yet. Its sender may go on at once, as it has a reply.
            self.gate.expect(source)


def _reject(protocol: GuardedProtocol, source: Source) -> None:
    protocol.gate.reject(source)


def _close_opened(opening: asyncio.Future[tuple[asyncio.DatagramTransport, GuardedProtocol]]) -> None:
    if not opening.cancelled() and opening.exception() is None:
        opening.result()[0].close()


class IceAgent:
    """Aioice connection with guarded sockets. To be made before the first description.

    Args:
        transport: ICE transport of the connection.
        gather: returns the candidates of the first description; may raise.
        permits: whether an address and port may be sent to.
        figures: count dropped datagrams.
        ingress: limits and turns shared by all agents.
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
        """False once the nominated path was lost at this end."""
        self.permits = permits
        self.figures = figures
        self._turns = ingress.turns
        self.admission = Admission(ingress.total)
        self._gather = gather
        self._name = f"{connection.local_username}:".encode()
        if ingress.takes_turns:
            transport._recv = TurnTaking(ingress.turns, connection.recv).receive
        self._replies = Allowance(time.monotonic, REPLIES_AT_ONCE, REPLIES_PER_SECOND)
        self.checks = Checks(connection, self._admit, _reject)
        self._aioice_check_state = connection.check_state
        self._aioice_check_incoming = connection.check_incoming
        self._aioice_respond_error = connection.respond_error
        connection.get_component_candidates = self._get_component_candidates  # type: ignore[method-assign]
        connection.check_state = self._check_state  # type: ignore[method-assign]
        connection.check_incoming = self._check_incoming  # type: ignore[method-assign, assignment]
        connection.respond_error = self._respond_error  # type: ignore[method-assign]
        self._aioice_sort_check_list = connection.sort_check_list
        connection.sort_check_list = self._sort_check_list  # type: ignore[method-assign]
        self._pair_limit_logged = False
        stop_consent_when_closed(connection)
        self._aioice_close = connection.close
        connection.close = self._close  # type: ignore[method-assign]

    @property
    def is_done(self) -> bool:
        """Whether a path was found, or the search has failed."""
        return self.connection._check_list_done

    def lost_way(self, protocol: GuardedProtocol) -> None:
        """Note a closed socket. A path over a relay is lost with the connection to its TURN server."""
        self.has_path &= all(pair.protocol is not protocol for pair in self.connection._nominated.values())

    @property
    def waiting(self) -> int:
        """Number of datagrams that wait for DTLS and SRTP."""
        return self.connection._queue.qsize()

    @property
    def paths(self) -> tuple[tuple[Candidate, str, int], ...]:
        """The nominated path, if there is one: the local candidate, and the other end's address and port."""
        return tuple((pair.local_candidate, *pair.remote_addr) for pair in self.connection._nominated.values())

    def adopt(self, protocol: GuardedProtocol) -> None:
        """Add a socket, which is closed with the connection."""
        self.connection._protocols.append(protocol)

    async def open_host(self, address: str, ports: Sequence[int]) -> Candidate:
        """Open a socket on the first of `ports` that is free.

        Raises:
            OSError: none is free, or the address is not this machine's.
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
                # uvloop leaves a socket open if its opening is cancelled.
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
        """Ask a STUN server under which address and port it sees the socket of `host`.

        Raises:
            aioice.stun.TransactionError: it does not answer.
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
        """Allocate a relay at a TURN server, and pair its address with all candidates of the other end.

        Args:
            server: the server.
            hide: whether the candidate hides the address by which this machine reached the server.

        Raises:
            aioice.stun.TransactionError, OSError: the server does not relay.
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
            await protocol.close()  # it is of no use any more, and a load on the server
            raise ConnectionError("the relay came too late to be of use")
        assert isinstance(protocol, GuardedProtocol), "it was made here"
        self.adopt(protocol)
        for remote in connection._remote_candidates:
            connection._pair_remote_candidate(remote)
        connection.sort_check_list()
        return candidate

    def add(self, candidate: Candidate) -> None:
        """Add `candidate` to all later descriptions."""
        self.connection._local_candidates.append(candidate)

    def is_meant(self, request: bytes) -> bool:
        """Tell whether a connectivity check names this agent (RFC 8445 section 7.2.2)."""
        return self._name in request

    @property
    def may_reply(self) -> bool:
        """Whether one more request without credentials may be answered."""
        return self._replies.has()

    def check(self, work: Callable[[], None], octets: int) -> None:
        """Run `work` on a connectivity check of so many bytes, now or in a later turn, if it is admitted."""
        if self._admits(Traffic.CHECK, octets) and not self._turns.run_or_defer(work):
            self.figures.overflow += 1

    def _admits(self, traffic: Traffic, octets: int) -> bool:
        """Tell whether one more datagram is admitted; dropped ones are counted."""
        match self.admission.judge(traffic, octets):
            case Verdict.PEER_LIMIT:
                self.figures.peer_limit += 1
            case Verdict.TOTAL_LIMIT:
                self.figures.total_limit += 1
            case Verdict.ADMITTED:
                return True
        return False

    def deliver(self, data: bytes) -> None:
        """Pass DTLS or SRTP of a proven source on."""
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
            protocol.gate.reject(pair.remote_addr)

    def _check_incoming(self, message: stun.Message, addr: Source, protocol: GuardedProtocol) -> None:
        """Handle an authentic check."""
        if "PRIORITY" not in message.attributes:
            self.figures.malformed += 1
        elif not protocol.gate.expect(addr):
            pass
        elif not self.is_done:
            # It may make a new pair, which must not be left out then.
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
        """Remove pairs of the lowest priority that are not being checked; whether no more than `limit` are left."""
        pairs = self.connection._check_list
        for pair in reversed(pairs[:]):
            if len(pairs) <= limit:
                return True
            if pair.task is None and pair.state in (_STATE.FROZEN, _STATE.WAITING):
                pairs.remove(pair)
                self._log_pair_limit()
        return len(pairs) <= limit

    def _log_pair_limit(self) -> None:
        if not self._pair_limit_logged:
            self._pair_limit_logged = True
            text = "a peer connection has more than %d candidate pairs: those of the lowest priority are not checked"
            _log.info(f"{text} (RFC 8445)", PAIRS_LIMIT)

    def _admit(self, protocol: GuardedProtocol, source: Source) -> None:
        for data in protocol.gate.admit(source):
            self.deliver(data)

    def _prove_others(self) -> None:
        """Check the expected sources: aioice gives up its other checks, but the other end may use another path."""
        if self.is_done:
            for protocol in self.connection._protocols:
                if isinstance(protocol, GuardedProtocol):
                    for source in protocol.gate.expected:
                        self.checks.prove(protocol, source)
