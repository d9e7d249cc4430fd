"""One peer connection of an application with an engine, and the streams in its sections."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from openrois_signaling.messages import IceServer, Offer
from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import SessionError
from openrois_streaming.viewing.answering import AnsweringConnection, ViewedSection
from openrois_streaming.viewing.speech_channel import SpeechChannel

from openrois_media.client.path_watch import PathWatch

__all__ = ["Attachment", "MediaPeer", "Place"]

_CONNECTED: Final = "connected"

_log = logging.getLogger(__name__)


class MediaPeer:
    """Peer connection, from its first offer to its end.

    Args:
        peer_id: its id.
        clock: the clock of capture times.
        ice_servers: STUN and TURN servers.
        on_candidate: called with candidates of this end that are found after the first answer.
        on_state: called when the state of the connection, or of its channels, has changed.
        on_told: called with what the body tells of speech.

    Attributes:
        speech: the channels of speech as sound, once an offer has some.
        leaving: whether its session has ended, or another peer replaces it: nothing new is negotiated on it.
        closed: whether it is being closed.
    """

    def __init__(
        self,
        peer_id: str,
        clock: MediaClock,
        ice_servers: Sequence[IceServer],
        on_candidate: Callable[[str | None], None],
        on_state: Callable[[], None],
        on_told: Callable[[str], None],
    ) -> None:
        self.peer_id = peer_id
        self.speech = SpeechChannel(on_told, on_state)
        self.watch = PathWatch()
        self.leaving = self.closed = False
        self.connection = AnsweringConnection(
            clock,
            ice_servers=ice_servers,
            on_state=lambda _state: on_state(),
            on_candidate=on_candidate,
            on_channels=self.speech.make,
        )
        self._sections: dict[str, ViewedSection] = {}

    @property
    def is_connected(self) -> bool:
        """Whether media can pass."""
        return self.connection.state == _CONNECTED

    @property
    def stream_ids(self) -> tuple[str, ...]:
        """Ids of the streams of the last offer that was answered."""
        return tuple(self._sections)

    def section(self, stream_id: str | None) -> ViewedSection | None:
        """Return the section that carries a stream; None if this peer does not."""
        return None if stream_id is None else self._sections.get(stream_id)

    async def apply(self, offer: Offer) -> str:
        """Apply an offer; returns the SDP of the answer.

        Raises:
            SessionError: it cannot be answered.
        """
        answer = await self.connection.answer_offer(offer.sdp, {each.mid: each.direction for each in offer.streams})
        known = self.connection.sections
        self._sections = {each.stream_id: known[each.mid] for each in offer.streams if each.mid in known}
        return answer

    async def add_candidate(self, candidate: str | None) -> None:
        """Add a candidate of the engine; an unusable one is skipped, as in ICE."""
        try:
            await self.connection.add_candidate(candidate)
        except SessionError as error:
            _log.info("a candidate of the engine is not used: %s", error)

    async def close(self) -> None:
        """Close the connection."""
        self.closed = True
        await self.connection.close()


@dataclass(eq=False)
class Attachment:
    """A section of one of the peers that carries a stream, and the frames that it had received before."""

    peer: MediaPeer
    section: ViewedSection
    before: int = 0

    @classmethod
    def of(cls, peer: MediaPeer, section: ViewedSection) -> "Attachment":
        """Return the attachment of a stream to a section, from now on."""
        return cls(peer, section, section.receiver.frames if section.receiver is not None else 0)

    @property
    def frames(self) -> int:
        """Whole frames that have arrived since, decoded or not."""
        return 0 if self.section.receiver is None else self.section.receiver.frames - self.before

    @property
    def source(self) -> Any:
        """The engine's media, a `MediaSource`; None in a section that is only sent in."""
        return None if self.section.receiver is None else self.section.receiver.source


class Place:
    """The section that carries a stream now, and the next one, used from its first frame on.

    Args:
        on_attached: called with each section that comes to carry the stream.
        on_left: called with each one that does no more.
    """

    def __init__(self, on_attached: Callable[[Attachment], None], on_left: Callable[[Attachment], None]) -> None:
        self.current: Attachment | None = None
        self.next: Attachment | None = None
        self.located = False
        """Whether the stream's present connection has a section; frames may still come from the former one."""
        self._on_attached = on_attached
        self._on_left = on_left

    @property
    def newest(self) -> Attachment | None:
        """The newest section."""
        return self.next or self.current

    @property
    def flowed(self) -> bool:
        """Whether media has flowed in the newest section."""
        return self.located and self.next is None and self.current is not None and self.current.frames > 0

    def attachments(self) -> tuple[Attachment, ...]:
        """Return all sections, the newest last."""
        return tuple(each for each in (self.current, self.next) if each is not None)

    def attach(self, peer: MediaPeer, section: ViewedSection) -> None:
        """Add a section that carries the stream; the first one is used at once."""
        newest = self.newest
        self.located = True
        if newest is not None and newest.peer is peer and newest.section is section:
            return
        if self.next is not None:
            self._on_left(self.next)
        self.next = Attachment.of(peer, section)
        self._on_attached(self.next)
        if self.current is None:
            self.promote()

    def promote(self) -> None:
        """Use the newest section alone; its first frame has come."""
        if self.next is not None:
            former, self.current, self.next = self.current, self.next, None
            if former is not None:
                self._on_left(former)

    def detach(self, peer: MediaPeer) -> None:
        """Leave a peer that is about to be closed."""
        if self.next is not None and self.next.peer is peer:
            self._leave_next()
        if self.current is not None and self.current.peer is peer:
            self._on_left(self.current)
            self.current = None
        if self.current is None:
            self.promote()

    def connection_ended(self) -> None:
        """Drop the next section, as the stream's connection has ended. What comes over the present one goes on."""
        self._leave_next()
        self.located = False

    def drop(self) -> None:
        """Leave all sections, as the stream is disconnected."""
        self.connection_ended()
        if self.current is not None:
            self._on_left(self.current)
            self.current = None

    def _leave_next(self) -> None:
        if self.next is not None:
            self._on_left(self.next)
            self.next = None
