"""Figures of one stream: its counters, and the snapshot that is published of them."""

from dataclasses import dataclass, fields, replace

from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.state import StreamStatus


@dataclass(frozen=True, slots=True)
class AdaptationStats:
    """Rendition that a viewer is sent at one moment, and the estimates behind that choice."""

    width: int
    height: int
    frame_rate: float
    """Of the rendition."""
    bitrate: int
    """Bit/s of video that the viewer is estimated to take."""
    path: int
    """Bit/s that the path is estimated to carry, everything included."""
    estimate: int | None
    """The viewer's own estimate of the path (REMB); None if it gives none."""
    probing: bool
    """Whether a higher rate is being probed now."""
    switches: int
    """Changes of rendition so far."""


@dataclass(frozen=True)
class ReceiverFigures:
    """Counters of one receiver. `jitter` and `playout_delay` are in seconds.

    `frames_dropped` could not be decoded or were not read in time; `concealed` are seconds of concealed loss.
    """

    packets: int
    bytes: int
    packets_lost: int
    nacks: int
    key_frame_requests: int
    key_frames: int
    frames_decoded: int
    frames_dropped: int
    jitter: float
    playout_delay: float
    concealed: float

    def since(self, before: "ReceiverFigures") -> "ReceiverFigures":
        """Return the counts since another reading; jitter and playout delay are those of now."""
        counted = {
            field.name: getattr(self, field.name) - getattr(before, field.name)
            for field in fields(self)
            if field.name not in ("jitter", "playout_delay")
        }
        return replace(self, **counted)


@dataclass(frozen=True, slots=True)
class StreamStats:
    """Snapshot of one stream. Counts run from its connection, also over a change of the peer connection."""

    stream_id: str
    component_ref: str
    kind: str
    status: StreamStatus
    codec: str | None
    """The negotiated media type; None before the first answer."""
    frames_sent: int
    frames_dropped: int
    """Frames that this viewer was too slow for, and those that could not be decoded without them."""
    key_frames: int
    """Key frames among the frames sent; every frame of audio is one."""
    bytes_sent: int
    """Bytes of the frames sent, without headers and repetitions."""
    key_frame_requests: int
    """PLI and FIR that arrived."""
    packets_sent: int
    """Of the present peer connection, as all that follows; without repetitions."""
    packets_retransmitted: int
    retransmissions_refused: int
    """Packets that were requested again in vain: the budget of repetitions was spent."""
    frames_received: int
    """Whole frames that arrived from the application, decoded or not."""
    path_bitrate: int | None
    """Bit/s that the viewer estimates its path to carry; None before its first estimate."""
    round_trip_time: float | None
    """Seconds, smoothed; None before the first report."""
    packets_lost: int | None
    """As the viewer reports."""
    fraction_lost: float | None
    """0..1, between the last two reports."""
    jitter: float | None
    """Seconds."""
    playout_delay: float | None = None
    """Seconds from the arrival of a packet until it is played, as last reported by the viewer; None without a
    report."""
    adaptation: AdaptationStats | None = None
    """None before the first decision, and for a source with one rendition."""
    reception: ReceiverFigures | None = None
    """Of the present peer connection; None where the application sends nothing."""


class Counters:
    """Counters of one stream while it runs."""

    __slots__ = ("bytes_sent", "frames_dropped", "frames_sent", "key_frame_requests", "key_frames")

    def __init__(self) -> None:
        self.frames_sent = 0
        self.frames_dropped = 0
        self.key_frames = 0
        self.bytes_sent = 0
        self.key_frame_requests = 0

    def sent(self, frame: EncodedFrame) -> None:
        """Count a frame that was handed to the network."""
        self.frames_sent += 1
        self.key_frames += frame.keyframe
        self.bytes_sent += len(frame.data)
