"""Figures of one stream: what was counted while it ran, and the snapshot others see."""

from dataclasses import dataclass

from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.receive.figures import ReceiverFigures
from openrois_streaming.state import StreamStatus


@dataclass(frozen=True, slots=True)
class AdaptationStats:
    """What a viewer is sent of a source, at one moment, and why."""

    width: int
    height: int
    frame_rate: float
    """Of the rendition that was chosen for it."""
    bitrate: int
    """Bit/s of pictures that it is thought to be able to take."""
    path: int
    """Bit/s that its path is thought to carry, everything included."""
    estimate: int | None
    """The viewer's own estimate of that (REMB); None if it gives none."""
    probing: bool
    """Whether more is being tried now."""
    switches: int
    """Changes from one rendition to another so far."""


@dataclass(frozen=True, slots=True)
class StreamStats:
    """One stream at one moment. Counts run from its connection, also over a change of the peer connection."""

    stream_id: str
    component_ref: str
    kind: str
    status: StreamStatus
    codec: str | None
    """The negotiated media type; None before the first answer."""
    frames_sent: int
    frames_dropped: int
    """Frames this viewer was too slow for, and those that were of no use to it without them."""
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
    """Packets that were asked for again in vain: the budget of repetitions was spent."""
    frames_received: int
    """Whole frames that came from the application, decoded or not."""
    path_bitrate: int | None
    """Bit/s that the viewer's path carries, as it says; None before its first word."""
    round_trip_time: float | None
    """Seconds, smoothed; None before the first report."""
    packets_lost: int | None
    """As the viewer reports it."""
    fraction_lost: float | None
    """0..1, between the last two reports."""
    jitter: float | None
    """Seconds."""
    playout_delay: float | None = None
    """Seconds from the arrival of a packet to its being played, as the viewer said last; None if it never did."""
    adaptation: AdaptationStats | None = None
    """None before the first decision, and where there is nothing to choose."""
    reception: ReceiverFigures | None = None
    """Of the present peer connection; None where the application sends nothing."""


class Counters:
    """What is counted for one stream while it runs."""

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
