"""The way of one source's packets through a receiver: pictures are assembled, sound is played out."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import H264, OPUS, VP8
from openrois_streaming.receive.assembly import Picture, Request, VideoAssembly, VideoPacket
from openrois_streaming.receive.inbound import MediaPacket
from openrois_streaming.receive.payloads import Depacketizer, h264_piece, vp8_piece
from openrois_streaming.receive.playout import SoundPacket
from openrois_streaming.receive.source_audio import AudioSource
from openrois_streaming.receive.source_video import EncodedPicture, VideoSource
from openrois_streaming.source.source import SAMPLE_RATE

_DEPACKETIZERS: dict[str, Depacketizer] = {H264: h264_piece, VP8: vp8_piece}

CaptureTime = Callable[[int, float], float]
"""The capture time of an unwrapped timestamp, and now."""

NOTHING = Request((), key_frame=False)


@dataclass(frozen=True)
class LaneFigures:
    """What became of the packets so far; seconds where it says delay or concealed."""

    decoded: int
    dropped: int
    playout_delay: float = 0.0
    concealed: float = 0.0
    key_frames: int = 0


class Lane(Protocol):
    """What a receiver does with the packets of its kind of media."""

    def add(self, packet: MediaPacket, arrival: float) -> int:
        """Take a packet in; returns how many whole frames that makes."""
        ...

    def attend(self, now: float) -> tuple[int, Request]:
        """Do what is due, when a packet came or `next_at` has come; returns whole frames and what to ask for."""
        ...

    @property
    def next_at(self) -> float | None:
        """When `attend` has something to do without a packet."""
        ...

    def pause(self) -> None:
        """What comes next has nothing to do with what was before."""
        ...

    def end(self) -> None:
        """Nothing more will come."""
        ...

    @property
    def figures(self) -> LaneFigures:
        """What was counted."""
        ...


class VideoLane:
    """Pictures: assembled, repaired, and decoded while somebody reads `source`.

    `on_wish` is called, from any thread, when there is something to ask the sender for.
    """

    def __init__(self, captured_at: CaptureTime, on_wish: Callable[[], None]) -> None:
        self.source = VideoSource(self._opened, self._lost, self._closed)
        self._captured_at = captured_at
        self._on_wish = on_wish
        self._assembly = VideoAssembly(vp8_piece)
        self._reference_lost = False
        self._key_frames = 0

    def add(self, packet: MediaPacket, arrival: float) -> int:
        """Take a packet in."""
        self._see(packet.mime_type)
        return self._pass(self._assembly.add(VideoPacket(*packet[1:]), arrival), arrival)

    def attend(self, now: float) -> tuple[int, Request]:
        """Give up what is not repaired in time, and ask for what is missing."""
        if self._reference_lost:
            self._reference_lost = False
            self._assembly.lose_reference()
        pictures, request = self._assembly.attend(now)
        return self._pass(pictures, now), request

    @property
    def next_at(self) -> float | None:
        """When a request or the end of the patience is due."""
        return self._assembly.next_at

    def pause(self) -> None:
        """Forget what is not whole; go on with a key frame."""
        self._assembly.pause()
        self._assembly.lose_reference()

    def end(self) -> None:
        """The source ends."""
        self.source.end()

    @property
    def figures(self) -> LaneFigures:
        """Pictures decoded, and dropped because they could not be or were not read in time; key frames that arrived."""
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
                captured_at = self._captured_at(picture.timestamp, now)
                self.source.offer(EncodedPicture(picture.data, picture.key_frame, captured_at))
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
    """Sound: played out while somebody reads `source`."""

    def __init__(self, clock: MediaClock, captured_at: CaptureTime) -> None:
        self.source = AudioSource(clock, captured_at)

    def add(self, packet: MediaPacket, arrival: float) -> int:
        """Take a packet in."""
        if packet.payload:
            self.source.offer(SoundPacket(packet.timestamp, packet.payload), arrival)
        return 1

    def attend(self, now: float) -> tuple[int, Request]:
        """Nothing is asked for: a lost packet would come too late."""
        return 0, NOTHING

    @property
    def next_at(self) -> float | None:
        """Never."""
        return None

    def pause(self) -> None:
        """Nothing to do: the playout makes up for what is missing."""

    def end(self) -> None:
        """The source ends."""
        self.source.end()

    @property
    def figures(self) -> LaneFigures:
        """Blocks played and not read in time, and what was done to the sound."""
        concealed = self.source.figures.concealed / SAMPLE_RATE
        return LaneFigures(self.source.decoded, self.source.dropped, self.source.delay, concealed)


DECODABLE = {"video": frozenset(_DEPACKETIZERS), "audio": frozenset({OPUS})}
"""The media types that can be received, by kind."""
