"""Processing of one source's packets in a receiver: pictures are assembled, sound is played out."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from openrois_streaming.codecs import H264, OPUS, VP8
from openrois_streaming.receive.assembly import Picture, Request, VideoAssembly, VideoPacket
from openrois_streaming.receive.inbound import MediaPacket
from openrois_streaming.receive.payloads import Depacketizer, h264_piece, vp8_piece
from openrois_streaming.receive.playout import SoundPacket
from openrois_streaming.receive.remote_time import CaptureTime
from openrois_streaming.receive.source_audio import AudioSource
from openrois_streaming.receive.source_video import EncodedPicture, MakePicture, VideoSource, raw_picture
from openrois_streaming.source.source import SAMPLE_RATE

_DEPACKETIZERS: dict[str, Depacketizer] = {H264: h264_piece, VP8: vp8_piece}

Captured = Callable[[int, float], CaptureTime]
"""Returns the capture time of an unwrapped timestamp, given the present time."""

NOTHING = Request((), key_frame=False)


@dataclass(frozen=True)
class LaneFigures:
    """Counts of one lane; delay and concealed sound in seconds."""

    decoded: int
    dropped: int
    playout_delay: float = 0.0
    concealed: float = 0.0
    key_frames: int = 0


class Lane(Protocol):
    """Processing of packets of one kind of media."""

    def add(self, packet: MediaPacket, arrival: float) -> int:
        """Add a packet; returns how many frames it completes."""
        ...

    def check_deadlines(self, now: float) -> tuple[int, Request]:
        """Process deadlines after a packet and at `next_at`; returns the number of completed frames, and requests."""
        ...

    @property
    def next_at(self) -> float | None:
        """Time of the next `check_deadlines` without a packet; None for never."""
        ...

    def pause(self) -> None:
        """Note that later packets have no relation to earlier ones."""
        ...

    def end_input(self) -> None:
        """End the source."""
        ...

    @property
    def figures(self) -> LaneFigures:
        """Counts so far."""
        ...


class VideoLane:
    """Lane of pictures: assembled, repaired, and decoded while `source` is open.

    `on_wish` is called, from any thread, when there is a request to the sender.
    """

    def __init__(self, captured: Captured, on_wish: Callable[[], None], make: MakePicture[Any] = raw_picture) -> None:
        self.source = VideoSource[Any](self._opened, self._lost, self._closed, make)
        self._captured = captured
        self._on_wish = on_wish
        self._assembly = VideoAssembly(vp8_piece)
        self._reference_lost = False
        self._key_frames = 0

    def add(self, packet: MediaPacket, arrival: float) -> int:
        """Add a packet."""
        self._see(packet.mime_type)
        return self._pass(self._assembly.add(VideoPacket(*packet[1:]), arrival), arrival)

    def check_deadlines(self, now: float) -> tuple[int, Request]:
        """Give up gaps that were not repaired in time, and request missing packets."""
        if self._reference_lost:
            self._reference_lost = False
            self._assembly.lose_reference()
        pictures, request = self._assembly.check_deadlines(now)
        return self._pass(pictures, now), request

    @property
    def next_at(self) -> float | None:
        """Time of the next request, or of giving up a gap."""
        return self._assembly.next_at

    def pause(self) -> None:
        """Drop incomplete pictures, and wait for a key frame."""
        self._assembly.pause()
        self._assembly.lose_reference()

    def end_input(self) -> None:
        """End the source."""
        self.source.end_input()

    @property
    def figures(self) -> LaneFigures:
        """Pictures decoded, and dropped as undecodable or not read in time; key frames that arrived."""
        return LaneFigures(self.source.decoded, self.source.dropped, key_frames=self._key_frames)

    def _see(self, mime_type: str) -> None:
        if mime_type != self.source.mime_type:
            self.source.mime_type = mime_type
            watched = self._assembly.watched
            self._assembly = VideoAssembly(_DEPACKETIZERS[mime_type])
            self._assembly.watched = watched

    def _pass(self, pictures: list[Picture], now: float) -> int:
        for picture in pictures:
            self._key_frames += picture.key_frame
            if picture.decodable and self._assembly.watched:
                captured = self._captured(picture.timestamp, now)
                self.source.offer(EncodedPicture(picture.data, picture.key_frame, captured))
        return len(pictures)

    def _opened(self) -> None:
        self._assembly.watched = True
        self._on_wish()

    def _closed(self) -> None:
        self._assembly.watched = False

    def _lost(self) -> None:
        self._reference_lost = True
        self._on_wish()


class AudioLane:
    """Lane of sound: played out while `source` is open."""

    def __init__(self, source: AudioSource) -> None:
        self.source = source

    def add(self, packet: MediaPacket, arrival: float) -> int:
        """Add a packet."""
        if packet.payload:
            self.source.offer(SoundPacket(packet.timestamp, packet.payload), arrival)
        return 1

    def check_deadlines(self, now: float) -> tuple[int, Request]:
        """Request nothing: a lost packet would come too late."""
        return 0, NOTHING

    @property
    def next_at(self) -> float | None:
        """None: sound has no deadlines here."""
        return None

    def pause(self) -> None:
        """Do nothing: the playout conceals missing sound."""

    def end_input(self) -> None:
        """End the source."""
        self.source.end_input()

    @property
    def figures(self) -> LaneFigures:
        """Blocks played and not read in time, and concealed sound."""
        concealed = self.source.figures.concealed / SAMPLE_RATE
        return LaneFigures(self.source.decoded, self.source.dropped, self.source.delay, concealed)


DECODABLE = {"video": frozenset(_DEPACKETIZERS), "audio": frozenset({OPUS})}
"""Media types that can be received, by kind."""
