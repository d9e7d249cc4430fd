"""One `RTCPeerConnection` and its m-sections; no other module drives aiortc."""

import asyncio
import logging
from collections.abc import Callable, Sequence

from aioice import Candidate
from aiortc import InvalidStateError, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtcicetransport import RTCIceTransport
from openrois_signaling.messages import SECTIONS_LIMIT, IceServer, StreamSection

from openrois_streaming.aiortc_internals.connection import contain_starts
from openrois_streaming.aiortc_internals.ice import IceAgent
from openrois_streaming.aiortc_internals.incoming import Incoming
from openrois_streaming.aiortc_internals.sending import DtlsWire
from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import InvalidCandidate, InvalidDescription, PeerClosed, TooManySections
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.servers import read_servers
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer.gathering import Gathering
from openrois_streaming.peer.input_channels import MakeChannels, OnMessage, OpenChannels
from openrois_streaming.peer.offer_parameters import level_of, with_levels, with_stereo
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.peer.sdp import OfferedSection, clean_answer, mids_of, read_candidate
from openrois_streaming.peer.section import Section, StreamPath
from openrois_streaming.peer.stream import Stream
from openrois_streaming.receive.remote_time import RemoteClock
from openrois_streaming.send.pacer import Outlet

CLOSE_TIMEOUT = 3.0
"""Seconds that aiortc has to close a connection."""

_END_OF_CANDIDATES = "a=end-of-candidates\r\n"

_log = logging.getLogger(__name__)


class BundledConnection:
    """Offering peer connection, with all its sections on one transport.

    Args:
        ice_servers: STUN and TURN servers; only a required relay is waited for.
        network: network settings.
        guarded: counts dropped datagrams.
        ingress: limits on received datagrams of all connections.
        clock: the clock of capture times.
        wall_offset: the time of day (epoch seconds) at which the media clock was 0. It does not follow a clock that is
            stepped, because sound and pictures would part for a while.
        on_state: called with "connected", "failed" or "closed", in a turn of the loop of its own.
        on_sign: called for each sign of life of the other end: each RTCP packet, and each answer to `ask_for_a_sign`.
        on_candidate: called with each candidate-attribute of this end found after the first description, and with None
            after the last.
    """

    def __init__(
        self,
        ice_servers: Sequence[IceServer],
        network: NetworkSettings,
        guarded: GuardFigures,
        ingress: Ingress,
        clock: MediaClock,
        wall_offset: float,
        on_state: Callable[[str], None],
        on_sign: Callable[[], None],
        on_candidate: Callable[[str | None], None],
    ) -> None:
        self.sections: list[Section] = []
        self._policy = network.policy
        self._guarded = guarded
        self._ingress = ingress
        self._clock = clock
        self._remote = RemoteClock()
        self._outlet = Outlet.made(clock, wall_offset, asyncio.get_running_loop().call_later)
        self._wire = DtlsWire()
        self._agent: IceAgent | None = None
        self._incoming: Incoming | None = None
        servers = read_servers(ice_servers)
        for reason in servers.unusable:
            _log.warning("an ICE server is not used: %s", reason)
        self._gathering = Gathering(network, servers, on_candidate)
        self._on_sign = on_sign
        self._offered: tuple[OfferedSection, ...] = ()
        self._closing: asyncio.Future[None] | None = None
        # With any other policy a later section would get a transport of its own, which disturbs the first.
        self._connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        contain_starts(self._connection)
        self._on_state = on_state
        self._connection.on("connectionstatechange", self._state_changed)

    def section_for(self, stream: Stream) -> Section:
        """Return an idle section that suits `stream`, or a new one.

        Raises:
            TooManySections: there is none, and the limit is reached.
            PeerClosed: the other end has closed it.
        """
        if self.sections and self.sections[0].transceiver.sender.transport.state == "closed":
            raise PeerClosed("the application has closed the peer connection")
        for section in self.sections:
            if section.suits(stream):
                return section
        if len(self.sections) >= SECTIONS_LIMIT:
            raise TooManySections(f"all {SECTIONS_LIMIT} sections are in use: disconnect a stream first")
        section = Section(self._connection, stream.kind, stream.codecs, self._outlet, self._wire, stream.direction)
        section.round_trip = self.round_trip
        if stream.uplink_selector is not None:
            section.reception = RtpReceiver(section.transceiver, self._clock, self._remote)
        self.sections.append(section)
        if len(self.sections) == 1:
            transport = section.transceiver.sender.transport
            self._agent = self._take_over(transport.transport)
            self._incoming = Incoming(transport, self._on_sign, self._guarded)
        return section

    def open_channels(self, make: MakeChannels, on_message: OnMessage, on_closed: Callable[[], None]) -> OpenChannels:
        """Make the data channels, once, for the next offer on; there must be a section."""
        return make(self._connection, self._guarded, on_message, on_closed)

    def _state_changed(self) -> None:
        """Call `on_state` in a later turn: aiortc may be closing, and the reaction must not disturb that."""
        state = self._connection.connectionState
        if state == "closed" and self._agent is not None and not self._agent.has_path:
            # DTLS ends as if closed by the other end.
            state = "failed"
        asyncio.get_running_loop().call_soon(self._on_state, state)

    def _take_over(self, transport: RTCIceTransport) -> IceAgent:
        async def gather() -> list[Candidate]:
            return await self._gathering.first(agent)

        agent = IceAgent(transport, gather, self._policy.permits_target, self._guarded, self._ingress)
        return agent

    @property
    def sender_failed(self) -> bool:
        """Whether a section can no longer send."""
        return any(section.sender.failed for section in self.sections)

    @property
    def misuse(self) -> str:
        """Abuse by the other end, as a sentence; empty if there is none."""
        if self._incoming is not None and self._incoming.crowded:
            return "the application sends from too many sources (SSRC)"
        if self._agent is not None and self._agent.admission.persists:
            return "the application sends more packets than the engine admits"
        return ""

    async def describe(self, generation: int) -> tuple[str, tuple[StreamSection, ...]]:
        """Make offer number `generation` of the present sections; returns it and the streams it lists.

        Raises:
            NoPath: media cannot leave this machine.
            PeerClosed: the other end has closed it.
        """
        described = [(section, section.stream_path) for section in self.sections]
        for section, path in described:
            section.describe()
            if path is not None and path.generation is None:
                path.generation = generation
        try:
            await self._connection.setLocalDescription(await self._connection.createOffer())
        except InvalidStateError as error:
            raise PeerClosed("the application has closed the peer connection") from error
        sdp = self._connection.localDescription.sdp
        media = {
            each.mid: OfferedSection(each.mid, each.kind, "inactive" if path is None else each.direction)
            for each, path in described
        }
        self._offered = tuple(media.get(mid) or OfferedSection(mid, "application", "inactive") for mid in mids_of(sdp))
        streams = tuple(_listed(section, path) for section, path in described if path is not None)
        if generation == 1 and self._agent is not None:
            self._gathering.go_on(self._agent)
        levels = {each.mid: None if path is None else level_of(path.stream) for each, path in described}
        sdp = with_levels(sdp, [levels.get(offered.mid) for offered in self._offered])
        stereo = {each.mid for each, path in described if path is not None and path.stream.stereo}
        sdp = with_stereo(sdp, [offered.mid in stereo for offered in self._offered])
        return sdp if self._gathering.complete else sdp.replace(_END_OF_CANDIDATES, ""), streams

    async def apply(self, sdp: str) -> tuple[str, ...]:
        """Apply an answer to the last offer; returns its candidate-attributes.

        Raises:
            InvalidDescription: it cannot be used. It may be half applied, so the connection cannot go on.
        """
        clean = clean_answer(sdp, self._offered)
        try:
            await self._connection.setRemoteDescription(RTCSessionDescription(clean.sdp, "answer"))
        except Exception as error:  # aiortc raises whatever it meets half-way through
            raise InvalidDescription("aiortc refuses the answer") from error
        for section, answered in zip(self.sections, clean.directions, strict=False):  # later ones are not offered yet
            section.negotiated(answered)
        return clean.candidates

    async def add_candidate(self, attribute: str, *, only_check: bool = False) -> None:
        """Add a candidate-attribute of the other end, or only check that it can be read.

        Raises:
            InvalidCandidate: it cannot be used.
        """
        # aiortc ignores candidates that name any other section of a bundle.
        candidate = read_candidate(attribute, self.sections[0].mid, self._policy)
        if candidate is None or only_check:
            return
        try:
            await self._connection.addIceCandidate(candidate)
        except Exception as error:  # aioice raises ValueError and others
            raise InvalidCandidate("the candidate cannot be used") from error

    async def ask_for_a_sign(self) -> None:
        """Call `on_sign` if the other end answers a connectivity check within 1.5 s."""
        if self._agent is not None and await self._agent.checks.answers(tries=2):
            self._on_sign()

    async def round_trip(self) -> float | None:
        """Measure the round trip of a packet behind all that was sent before, in seconds.

        None without an answer within 1.5 s: paths over satellites take half of that.
        """
        since = self._clock.now()
        if self._agent is None or not await self._agent.checks.answers(tries=2):
            return None
        return self._clock.now() - since

    async def close(self) -> None:
        """Close the connection, within `CLOSE_TIMEOUT`."""
        await self._gathering.aclose()
        self._outlet.pacer.close()
        # aiortc may be closing by itself, and a cancelled waiter would break that; so this is only awaited.
        closing = self._closing = asyncio.ensure_future(self._connection.close())
        done, _ = await asyncio.wait({closing}, timeout=CLOSE_TIMEOUT)
        self._wire.close()
        if done:
            closing.result()
        else:
            _log.error("a peer connection is not closed after %.0f s", CLOSE_TIMEOUT)


def _listed(section: Section, path: StreamPath) -> StreamSection:
    return StreamSection(
        mid=section.mid,
        stream_id=path.stream.stream_id,
        component_ref=path.stream.component_ref,
        kind=section.kind,
        direction=section.direction,
    )
