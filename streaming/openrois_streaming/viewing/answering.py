"""Answering peer connection: the sections of an offer, received and sent."""

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from aioice import Candidate
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCRtpTransceiver, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_signaling.messages import Direction, IceServer

from openrois_streaming.aiortc_internals.connection import contain_starts
from openrois_streaming.aiortc_internals.ice import IceAgent
from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import InvalidCandidate, InvalidDescription
from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.servers import read_servers
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer.gathering import Gathering
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.peer.sdp import read_candidate
from openrois_streaming.receive.decoded import DecodedPictures
from openrois_streaming.receive.lane import Captured
from openrois_streaming.receive.remote_time import RemoteClock
from openrois_streaming.receive.source_audio import LoopAudioSource
from openrois_streaming.source.source import SAMPLE_RATE
from openrois_streaming.viewing.outgoing import OutgoingTrack

CLOSE_TIMEOUT: Final = 3.0
"""Seconds that aiortc has to close a connection."""

VIEWER_NETWORK: Final = NetworkSettings(
    admission=AdmissionSettings(
        peer_packets=20_000, peer_bytes=25_000_000, total_packets=100_000, total_bytes=125_000_000
    )
)
"""All interfaces, and room for what an application asks for itself: 200 Mbit/s for each engine."""

LONGEST_BLOCK: Final = SAMPLE_RATE // 50
"""Samples of a block of sound at most: the 20 ms of a usual packet, each handed over when it is due."""

_END_OF_CANDIDATES: Final = "a=end-of-candidates\r\n"

_log = logging.getLogger(__name__)


@dataclass(slots=True)
class ViewedSection:
    """m-section of an offer that was answered.

    Attributes:
        mid: its name.
        kind: "video" or "audio".
        receiver: the engine's media, decoded while its source is open, as `DecodedPicture` and `ReceivedAudio`; None in
            a section that was only sent in.
        outgoing: what this end sends in it; None in a section that was only received.
    """

    mid: str
    kind: str
    receiver: RtpReceiver | None = None
    outgoing: OutgoingTrack | None = None


class AnsweringConnection:
    """Peer connection that answers offers. To be closed.

    Args:
        clock: the clock of capture times.
        ice_servers: STUN and TURN servers; no answer waits for them.
        network: the interfaces and ports that media may use.
        on_state: called with each state of the connection (W3C's RTCPeerConnectionState).
        on_candidate: called with each candidate-attribute of this end found after the first answer, and with None
            after the last.
        on_received: called with a section when an offer has media of the engine in it for the first time.
        on_channels: called once, with the connection, when an offer has a section of data channels.
    """

    def __init__(
        self,
        clock: MediaClock,
        *,
        ice_servers: Sequence[IceServer] = (),
        network: NetworkSettings = VIEWER_NETWORK,
        on_state: Callable[[str], None] = lambda _state: None,
        on_candidate: Callable[[str | None], None] = lambda _candidate: None,
        on_received: Callable[[ViewedSection], None] = lambda _section: None,
        on_channels: Callable[[RTCPeerConnection], None] = lambda _connection: None,
    ) -> None:
        self.sections: dict[str, ViewedSection] = {}
        """The sections for media of all offers so far, by mid."""
        self._clock = clock
        self._remote = RemoteClock()
        self._policy = network.policy
        self._ingress = Ingress(network.admission, takes_turns=False)
        servers = read_servers(ice_servers)
        for reason in servers.unusable:
            _log.warning("an ICE server is not used: %s", reason)
        self._gathering = Gathering(network, servers, on_candidate)
        self._agent: IceAgent | None = None
        self._on_received = on_received
        self._on_channels: Callable[[RTCPeerConnection], None] | None = on_channels
        self._connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        contain_starts(self._connection)
        self._connection.on("track", self._receive)
        self._connection.on("connectionstatechange", lambda: on_state(self._connection.connectionState))

    @property
    def state(self) -> str:
        """State of the connection (W3C's RTCPeerConnectionState)."""
        state: str = self._connection.connectionState
        return state

    @property
    def mid(self) -> str:
        """Name of the first section, to which candidates of this end belong; empty before the first offer."""
        return next(iter(self.sections), "")

    async def answer_offer(self, sdp: str, directions: Mapping[str, Direction] | None = None) -> str:
        """Answer the SDP of an offer; returns the answer, with the candidates known by now.

        Args:
            sdp: the offer.
            directions: what this end does in the sections of these names; nothing in others. None: all that is offered
                is received.

        Raises:
            InvalidDescription: it cannot be answered. It may be half applied, so the connection cannot go on.
            NoPath: media cannot leave this machine.
        """
        connection = self._connection
        try:
            await connection.setRemoteDescription(RTCSessionDescription(sdp, "offer"))
        except Exception as error:  # aiortc raises whatever it meets half-way through
            raise InvalidDescription(f"the offer cannot be applied: {error}") from error
        transceivers = connection.getTransceivers()
        for transceiver in transceivers:
            self._follow(transceiver, directions)
        first = self._agent is None and bool(transceivers)
        agent = self._agent = self._agent or self._take_over(transceivers)
        if connection.sctp is not None and self._on_channels is not None:
            self._on_channels(connection)
            self._on_channels = None
        try:
            await connection.setLocalDescription(await connection.createAnswer())
        except Exception as error:  # it may have been closed meanwhile
            raise InvalidDescription(f"the offer cannot be answered: {error}") from error
        if first and agent is not None:
            self._gathering.go_on(agent)
        answer: str = connection.localDescription.sdp
        return answer if self._gathering.complete else answer.replace(_END_OF_CANDIDATES, "")

    async def add_candidate(self, attribute: str | None) -> None:
        """Add a candidate-attribute of the other end, once an offer was answered; None: there are no more.

        Raises:
            InvalidCandidate: it cannot be used.
        """
        candidate = read_candidate(attribute, self.mid, self._policy) if attribute else None
        if attribute and candidate is None:
            return
        try:
            await self._connection.addIceCandidate(candidate)
        except Exception as error:  # aioice raises ValueError and others
            raise InvalidCandidate("the candidate cannot be used") from error

    async def close(self) -> None:
        """Close the connection, within `CLOSE_TIMEOUT`; all of its media ends. Idempotent."""
        await self._gathering.aclose()
        # aiortc may be closing by itself, and a cancelled waiter would break that; so this is only awaited.
        closing = asyncio.ensure_future(self._connection.close())
        done, _ = await asyncio.wait({closing}, timeout=CLOSE_TIMEOUT)
        if done:
            closing.result()
        else:
            _log.error("a peer connection is not closed after %.0f s", CLOSE_TIMEOUT)

    def _section_of(self, transceiver: RTCRtpTransceiver) -> ViewedSection:
        mid = str(transceiver.mid)
        return self.sections.setdefault(mid, ViewedSection(mid, transceiver.kind))

    def _receive(self, track: MediaStreamTrack) -> None:
        """Take over the receiver of a section whose media are offered for the first time."""
        (transceiver,) = (each for each in self._connection.getTransceivers() if each.receiver.track is track)
        section = self._section_of(transceiver)
        section.receiver = RtpReceiver(transceiver, self._clock, self._remote, _audio_source, DecodedPictures())
        self._on_received(section)

    def _follow(self, transceiver: RTCRtpTransceiver, directions: Mapping[str, Direction] | None) -> None:
        section = self._section_of(transceiver)
        if directions is None:
            return
        direction = directions.get(section.mid)
        if direction in ("sendonly", "sendrecv"):
            if section.outgoing is None:
                section.outgoing = OutgoingTrack(section.kind)
                transceiver.sender.replaceTrack(section.outgoing)
        elif section.outgoing is not None:
            # What was sent in a section whose stream is over must not go to the next stream that gets it.
            section.outgoing.clear()
        transceiver.direction = direction or "inactive"

    def _take_over(self, transceivers: Sequence[RTCRtpTransceiver]) -> IceAgent | None:
        if not transceivers:
            return None

        async def gather() -> list[Candidate]:
            return await self._gathering.first(agent)

        transport = transceivers[0].receiver.transport.transport
        agent = IceAgent(transport, gather, self._policy.permits_target, GuardFigures(), self._ingress)
        return agent


def _audio_source(clock: MediaClock, captured: Captured) -> LoopAudioSource:
    return LoopAudioSource(clock, captured, LONGEST_BLOCK)
