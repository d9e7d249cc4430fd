"""One `RTCPeerConnection` and its m-sections: the only place that drives aiortc."""

import asyncio
import logging
from collections.abc import Callable, Sequence

from aiortc import RTCConfiguration, RTCIceServer, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtcicetransport import parse_stun_turn_uri
from openrois_signaling.messages import SECTIONS_LIMIT, IceServer, StreamSection

from openrois_streaming import aiortc_seams
from openrois_streaming.errors import InvalidCandidate, InvalidDescription, TooManySections
from openrois_streaming.sdp import CandidatePolicy, OfferedSection, clean_answer, read_candidate
from openrois_streaming.section import Leg, Section
from openrois_streaming.stream import Stream

CLOSE_TIMEOUT = 3.0
"""Seconds that aiortc has to close a connection."""

_log = logging.getLogger(__name__)


def usable_servers(servers: Sequence[IceServer]) -> list[RTCIceServer]:
    """`servers` as aiortc takes them, without URLs that it cannot read: one of those must not end every connection."""
    usable = []
    for server in servers:
        for url in server.urls:
            try:
                parse_stun_turn_uri(url)
            except ValueError:
                _log.warning("the ICE server %s is not used: its URL cannot be read", url)
            else:
                usable.append(RTCIceServer(url, server.username, server.credential))
    return usable


class BundledConnection:
    """A peer connection that offers, with all its sections on one transport.

    Args:
        ice_servers: of which aiortc uses the first STUN and the first TURN server.
        policy: the addresses of the other end that may be sent to.
        wall_offset: the time of day (epoch seconds) at which the media clock was 0. It does not follow a clock that is
            stepped, because sound and pictures would part for a while.
        on_state: called with "connected", "failed" or "closed".
        on_rtcp: called for each RTCP packet of the other end.
    """

    def __init__(
        self,
        ice_servers: Sequence[IceServer],
        policy: CandidatePolicy,
        wall_offset: float,
        on_state: Callable[[str], None],
        on_rtcp: Callable[[], None],
    ) -> None:
        self.sections: list[Section] = []
        self._policy = policy
        self._wall_offset = wall_offset
        self._on_rtcp = on_rtcp
        self._offered: tuple[OfferedSection, ...] = ()
        self._closing: asyncio.Future[None] | None = None
        # With any other policy a later section would get a transport of its own, which disturbs the first.
        self._connection = RTCPeerConnection(
            RTCConfiguration(iceServers=usable_servers(ice_servers), bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)
        )
        self._connection.on("connectionstatechange", lambda: on_state(self._connection.connectionState))

    def section_for(self, stream: Stream) -> Section:
        """An idle section that `stream` can take over, or a new one.

        Raises:
            TooManySections: there is none, and no room for another.
        """
        for section in self.sections:
            if section.suits(stream):
                return section
        if len(self.sections) >= SECTIONS_LIMIT:
            raise TooManySections(f"the peer connection has {SECTIONS_LIMIT} sections, and none to spare")
        section = Section(self._connection, stream.kind, stream.codecs, self._wall_offset)
        self.sections.append(section)
        if len(self.sections) == 1:
            transport = section.transceiver.sender.transport
            aiortc_seams.limit_gathering(transport.transport)
            aiortc_seams.watch_rtcp(transport, self._on_rtcp)
        return section

    @property
    def sender_failed(self) -> bool:
        """Whether aiortc gave up sending in a section; it cannot be made to start again."""
        return any(section.track.readyState == "ended" for section in self.sections)

    async def describe(self, generation: int) -> tuple[str, tuple[StreamSection, ...]]:
        """Make offer number `generation` of the sections as they are now; returns it and the streams it lists."""
        described = [(section, section.leg) for section in self.sections]
        for section, leg in described:
            section.transceiver.direction = "inactive" if leg is None else "sendonly"
            if leg is not None and leg.generation is None:
                leg.generation = generation
        await self._connection.setLocalDescription(await self._connection.createOffer())
        self._offered = tuple(OfferedSection(each.mid, each.kind, leg is not None) for each, leg in described)
        streams = tuple(_listed(section, leg) for section, leg in described if leg is not None)
        return self._connection.localDescription.sdp, streams

    async def apply(self, sdp: str) -> tuple[str, ...]:
        """Apply an answer to the last offer; returns the candidate-attributes that were in it.

        Raises:
            InvalidDescription: it cannot be used. It may be half applied: the connection is of no more use.
        """
        clean = clean_answer(sdp, self._offered)
        try:
            await self._connection.setRemoteDescription(RTCSessionDescription(clean.sdp, "answer"))
        except Exception as error:  # aiortc raises whatever it meets half-way through
            raise InvalidDescription("the answer was refused") from error
        for section in self.sections[: len(self._offered)]:
            section.negotiated()
        return clean.candidates

    async def add_candidate(self, attribute: str, *, only_check: bool = False) -> None:
        """Add a candidate-attribute of the other end, or see only whether it can be read.

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

    async def ask_for_a_sign(self) -> bool:
        """Whether the other end answers within 0.5 s."""
        return await aiortc_seams.ask_for_a_sign(self.sections[0].transceiver.sender.transport.transport)

    async def close(self) -> None:
        """Close it, within `CLOSE_TIMEOUT`."""
        # aiortc may be closing by itself, and a waiter that is cancelled would break that; so this is only waited for.
        closing = self._closing = asyncio.ensure_future(self._connection.close())
        done, _ = await asyncio.wait({closing}, timeout=CLOSE_TIMEOUT)
        if done:
            closing.result()
        else:
            _log.error("a peer connection is not closed after %.0f s", CLOSE_TIMEOUT)


def _listed(section: Section, leg: Leg) -> StreamSection:
    return StreamSection(
        mid=section.mid,
        stream_id=leg.stream.stream_id,
        component_ref=leg.stream.component_ref,
        kind=section.kind,
        direction="recvonly",
    )
