"""Gathering of ICE candidates: this machine's addresses at once, and those of servers when they answer."""

import asyncio
import logging
import random
import socket
from collections.abc import Callable, Sequence
from typing import Final

from aioice import Candidate, stun

from openrois_streaming.aiortc_internals.ice import IceAgent, local_candidate
from openrois_streaming.errors import NoPath
from openrois_streaming.network.interfaces import NoInterface, media_addresses
from openrois_streaming.network.servers import Servers, StunServer, TurnServer
from openrois_streaming.network.settings import NetworkSettings, PortRange
from openrois_streaming.tasks import OwnedTasks

SERVER_TIMEOUT = 10.0
"""Seconds that a server has to answer. Descriptions do not wait for it."""

RELAY_TIMEOUT = 4.0
"""Seconds that TURN servers have where only a relay may be used; less than an offer may take to be made."""

PORT_TRIES: Final = 256
"""Ports of a range tried for one socket."""

_HIDDEN: Final = ("0.0.0.0", 9)  # noqa: S104 hides the related address (RFC 8839 section 5.1)

_log = logging.getLogger(__name__)


class Gathering:
    """Candidates of one connection.

    `first` is for the first description; `go_on` then asks the servers, and `on_candidate` gets their candidates as
    attributes (RFC 8839 section 5.1), and None after the last. To be closed.
    """

    def __init__(self, network: NetworkSettings, servers: Servers, on_candidate: Callable[[str | None], None]) -> None:
        self._network = network
        self._servers = servers
        self._on_candidate = on_candidate
        self._hosts: list[Candidate] = []
        self._known: set[tuple[str, int]] = set()
        self._tasks = OwnedTasks("gathering", self._failed)
        self.complete = not servers
        """Whether gathering is complete."""

    async def first(self, agent: IceAgent) -> list[Candidate]:
        """Return the first candidates: of this machine, or of relays where those are required.

        Raises:
            NoPath: there are none; the text says why.
        """
        if self._network.relay_only:
            self.complete = True
            return await self._relays_alone(agent)
        ports = _ports(self._network.ports)
        try:
            addresses = media_addresses(self._network.interfaces)
        except NoInterface as error:
            _log.error("%s", error)
            raise NoPath("the engine lacks the network interface that --interface names") from None
        refused: OSError | None = None
        for address in addresses:
            try:
                self._hosts.append(await agent.open_host(address, ports))
            except OSError as error:
                refused = error
                _log.warning("media cannot use %s: %s", address, error.strerror or error)
        if not self._hosts:
            ports_used = "none of the engine's UDP ports are free: widen --udp-ports"
            no_address = "none of the engine's addresses can be used: choose others with --interface"
            raise NoPath(ports_used if self._network.ports else no_address) from refused
        return [candidate for host in self._hosts for candidate in self._candidates_of(host)]

    def go_on(self, agent: IceAgent) -> None:
        """Ask the servers for candidates. To be called once, when the first description is made."""
        if not self.complete:
            self._tasks.start(self._ask_all(agent), "servers")

    async def aclose(self) -> None:
        """Stop asking servers."""
        await self._tasks.aclose()

    def _candidates_of(self, host: Candidate) -> list[Candidate]:
        """Return the candidates of one socket of this machine that need no server."""
        candidates = []
        if self._network.policy.permits(host.host) or self._network.candidates == "lan":
            candidates.append(host)
        public = self._network.public_address
        if public is not None and ":" not in host.host and public != host.host:
            candidates.append(self._reflexive(host, public, host.port))
        self._known.update((each.host, each.port) for each in candidates)
        return candidates

    def _reflexive(self, host: Candidate, address: str, port: int) -> Candidate:
        related = (host.host, host.port) if self._network.candidates == "lan" else _HIDDEN
        return local_candidate("srflx", address, port, base=host.host, related=related)

    async def _ask_all(self, agent: IceAgent) -> None:
        asked = [self._ask_stun(agent, host, server) for server in self._servers.stun for host in self._hosts]
        asked += [self._ask_turn(agent, server) for server in self._servers.turn]
        await asyncio.gather(*asked)
        self.complete = True
        self._on_candidate(None)

    async def _ask_stun(self, agent: IceAgent, host: Candidate, server: StunServer) -> None:
        try:
            async with asyncio.timeout(SERVER_TIMEOUT):
                family = socket.AF_INET6 if ":" in host.host else socket.AF_INET
                found = await asyncio.get_running_loop().getaddrinfo(
                    server.host, server.port, family=family, type=socket.SOCK_DGRAM
                )
                address, port = await agent.ask_stun(host, (str(found[0][4][0]), server.port))
        except (OSError, stun.TransactionError) as error:
            _log.info("%s does not answer how %s is seen: %r", server.url, host.host, error)
            return
        if (address, port) not in self._known:
            self._known.add((address, port))
            self._found(agent, self._reflexive(host, address, port))

    async def _ask_turn(self, agent: IceAgent, server: TurnServer) -> None:
        try:
            async with asyncio.timeout(SERVER_TIMEOUT):
                relay = await agent.allocate(server, hide=self._network.candidates == "public")
        except (OSError, stun.TransactionError) as error:
            if not agent.is_done:
                _log.info("%s does not relay: %s", server.url, explain(error))
            return
        self._found(agent, relay)

    def _found(self, agent: IceAgent, candidate: Candidate) -> None:
        agent.add(candidate)
        self._on_candidate(f"candidate:{candidate.to_sdp()}")

    async def _relays_alone(self, agent: IceAgent) -> list[Candidate]:
        if not self._servers.turn:
            raise NoPath("the engine is set to relays only and has no TURN server: configure one")
        tries = [
            self._tasks.start(_within(RELAY_TIMEOUT, agent, server), f"relay {server.host}")
            for server in self._servers.turn
        ]
        relays: list[Candidate] = []
        why = ""
        for server, tried in zip(self._servers.turn, tries, strict=True):
            outcome = await tried
            if isinstance(outcome, Candidate):
                relays.append(outcome)
            else:
                why = explain(outcome)
                _log.warning("%s does not relay: %s", server.url, why)
        if not relays:
            raise NoPath(f"the engine is set to relays only and got none: {why}")
        return relays

    @staticmethod
    def _failed(error: BaseException) -> None:
        _log.error("an internal error stopped gathering", exc_info=error)


async def _within(seconds: float, agent: IceAgent, server: TurnServer) -> Candidate | Exception:
    try:
        async with asyncio.timeout(seconds):
            return await agent.allocate(server, hide=True)
    except (OSError, stun.TransactionError) as error:
        return error


def explain(error: Exception) -> str:
    """Return why a TURN server does not relay, as a clause for a person."""
    if isinstance(error, stun.TransactionFailed):
        if error.response.error_code in (401, 403, 438, 441):
            return "the TURN server refuses the credentials"
        if error.response.error_code in (486, 508):
            return "the TURN server has no relay to spare"
        return f"the TURN server refuses with {error.response.error_code}"
    if isinstance(error, TimeoutError | stun.TransactionTimeout):
        return "the TURN server does not answer"
    return "the TURN server cannot be reached"


def _ports(chosen: PortRange | None) -> Sequence[int]:
    """Return the ports to try, in an order that spreads the sockets; 0 is any."""
    if chosen is None:
        return (0,)
    every = range(chosen.first, chosen.last + 1)
    return random.sample(every, min(len(every), PORT_TRIES))
