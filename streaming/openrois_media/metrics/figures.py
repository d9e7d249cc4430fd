"""Figures of an adapter: name, unit and meaning of each, and a snapshot of all."""

from dataclasses import dataclass
from typing import Any, Final

from openrois_streaming.publish.rendition import RenditionFigures
from openrois_streaming.state import StreamStatus
from openrois_streaming.stats import AdaptationStats, ReceiverFigures, StreamStats

from openrois.metrics.figure import Figure
from openrois.types.codes import ComponentStatus
from openrois_media.health import GRAVITY
from openrois_media.visitors.figures import VisitorFigures
from openrois_media.visitors.registry import MAX_VISITORS

__all__ = [
    "ADAPTATION",
    "ADAPTER",
    "GUARD",
    "GUARD_LABELS",
    "RECEPTION",
    "RENDITION",
    "SOURCE",
    "STATUSES",
    "STREAM",
    "VISITORS",
    "FigureGroup",
    "Process",
    "Snapshot",
    "Source",
]


@dataclass(frozen=True, slots=True)
class Source:
    """Source of frames: the game engine, the picture, the sound."""

    name: str
    status: ComponentStatus
    frames: int
    last_frame_age: float | None
    """Seconds; None if it has given none since it was started."""
    encoders: int | None = None
    """Number of its running encoders; None for an engine."""


@dataclass(frozen=True, slots=True)
class Process:
    """Process of the adapter."""

    sessions: int
    sessions_limit: int
    tasks: int
    threads: int
    unanswered: int = 0
    displaced: int = 0


@dataclass(frozen=True, slots=True)
class FigureGroup:
    """Figures of one kind of object, and the objects, each after the values of its labels."""

    figures: tuple[Figure[Any], ...]
    labels: tuple[str, ...]
    samples: tuple[tuple[tuple[str, ...], Any], ...]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """All figures at one moment, without ended streams and their labels."""

    process: Process
    sources: tuple[Source, ...]
    renditions: tuple[tuple[str, RenditionFigures], ...]
    """Each with the name of its source."""
    streams: tuple[StreamStats, ...]
    guarded: tuple[tuple[str, int], ...] = ()
    """Dropped datagrams, by reason (a field of `GuardFigures`)."""
    more: tuple[FigureGroup, ...] = ()
    """Figures of the adapter beside streaming."""
    visitors: VisitorFigures | None = None
    """None where the adapter tells none apart."""


STREAM_LABELS: Final = ("stream", "component", "kind", "codec")
RENDITION_LABELS: Final = ("source", "codec", "rung")
SOURCE_LABELS: Final = ("source",)

STREAM: Final[tuple[Figure[StreamStats], ...]] = (
    Figure("openrois_stream_frames_total", "counter", "Frames sent.", lambda s: s.frames_sent),
    Figure("openrois_stream_bytes_total", "counter", "Bytes of the frames sent.", lambda s: s.bytes_sent),
    Figure(
        "openrois_stream_dropped_frames_total",
        "counter",
        "Frames not sent because the viewer or its path was too slow.",
        lambda s: s.frames_dropped,
    ),
    Figure("openrois_stream_key_frames_total", "counter", "Key frames sent; all of sound are.", lambda s: s.key_frames),
    Figure(
        "openrois_stream_key_frame_requests_total",
        "counter",
        "Key frames the viewer asked for (PLI, FIR).",
        lambda s: s.key_frame_requests,
    ),
    Figure("openrois_stream_packets_total", "counter", "Packets sent, without repetitions.", lambda s: s.packets_sent),
    Figure(
        "openrois_stream_retransmitted_packets_total",
        "counter",
        "Packets sent again because the viewer missed them.",
        lambda s: s.packets_retransmitted,
    ),
    Figure(
        "openrois_stream_refused_retransmissions_total",
        "counter",
        "Packets the viewer missed and did not get again: too many were lost.",
        lambda s: s.retransmissions_refused,
    ),
    Figure(
        "openrois_stream_received_frames_total",
        "counter",
        "Frames that came from the application (microphone, camera).",
        lambda s: s.frames_received,
    ),
    Figure(
        "openrois_stream_path_bits_per_second",
        "gauge",
        "Bit rate that the viewer's path carries, as the viewer says.",
        lambda s: s.path_bitrate,
    ),
    Figure(
        "openrois_stream_round_trip_seconds",
        "gauge",
        "Round trip to the viewer, smoothed.",
        lambda s: s.round_trip_time,
    ),
    Figure(
        "openrois_stream_lost_packets",
        "gauge",
        "Packets lost on the present peer connection, as the viewer reports.",
        lambda s: s.packets_lost,
    ),
    Figure(
        "openrois_stream_loss_ratio",
        "gauge",
        "Share of packets lost between the viewer's last two reports.",
        lambda s: s.fraction_lost,
    ),
    Figure("openrois_stream_jitter_seconds", "gauge", "Jitter, as the viewer reports.", lambda s: s.jitter),
    Figure(
        "openrois_stream_viewer_playout_seconds",
        "gauge",
        "Time that media waits at the viewer until it is played, as the viewer reports.",
        lambda s: s.playout_delay,
    ),
)

ADAPTATION: Final[tuple[Figure[AdaptationStats], ...]] = (
    Figure(
        "openrois_stream_width_pixels",
        "gauge",
        "Width of the rendition that was chosen for the viewer.",
        lambda a: a.width,
    ),
    Figure(
        "openrois_stream_height_pixels",
        "gauge",
        "Height of the rendition that was chosen for the viewer.",
        lambda a: a.height,
    ),
    Figure(
        "openrois_stream_rendition_switches_total",
        "counter",
        "Changes of the viewer from one rendition to another.",
        lambda a: a.switches,
    ),
    Figure(
        "openrois_stream_usable_bits_per_second",
        "gauge",
        "Bit rate that the viewer's path is taken to carry, everything included.",
        lambda a: a.path,
    ),
)
"""Figures of streams with several renditions; with the labels of a stream."""

RECEPTION: Final[tuple[Figure[ReceiverFigures], ...]] = (
    Figure(
        "openrois_stream_received_packets_total",
        "counter",
        "Packets that came from the application.",
        lambda r: r.packets,
    ),
    Figure(
        "openrois_stream_received_lost_packets",
        "gauge",
        "Packets of the application that were lost on the present peer connection.",
        lambda r: r.packets_lost,
    ),
    Figure(
        "openrois_stream_received_dropped_frames_total",
        "counter",
        "Pictures of the application that could not be decoded, or were not read in time.",
        lambda r: r.frames_dropped,
    ),
    Figure(
        "openrois_stream_received_jitter_seconds",
        "gauge",
        "Jitter of the application's packets.",
        lambda r: r.jitter,
    ),
    Figure(
        "openrois_stream_playout_delay_seconds",
        "gauge",
        "Time that the application's sound waits, so that it is played without gaps.",
        lambda r: r.playout_delay,
    ),
    Figure(
        "openrois_stream_concealed_seconds_total",
        "counter",
        "Sound that replaced lost sound of the application.",
        lambda r: r.concealed,
    ),
)
"""Figures of streams that applications send; with the labels of a stream."""

RENDITION: Final[tuple[Figure[RenditionFigures], ...]] = (
    Figure("openrois_rendition_viewers", "gauge", "Streams that play it now.", lambda r: r.viewers),
    Figure("openrois_rendition_running", "gauge", "1 while its encoder runs.", lambda r: r.running),
    Figure(
        "openrois_rendition_target_bits_per_second",
        "gauge",
        "Bit rate that its encoder aims at.",
        lambda r: r.bitrate,
    ),
    Figure("openrois_rendition_frames_total", "counter", "Frames encoded.", lambda r: r.encoded),
    Figure("openrois_rendition_bytes_total", "counter", "Bytes encoded.", lambda r: r.encoded_bytes),
    Figure("openrois_rendition_key_frames_total", "counter", "Key frames encoded.", lambda r: r.key_frames),
    Figure(
        "openrois_rendition_start_key_frames_total",
        "counter",
        "Key frames made for viewers that started.",
        lambda r: r.starts,
    ),
    Figure(
        "openrois_rendition_repair_key_frames_total",
        "counter",
        "Key frames made for viewers that lost data.",
        lambda r: r.repairs,
    ),
    Figure(
        "openrois_rendition_dropped_frames_total",
        "counter",
        "Frames lost because the encoder was busy.",
        lambda r: r.dropped_input,
    ),
    Figure(
        "openrois_rendition_encoder_seconds_total",
        "counter",
        "Time spent in the encoder.",
        lambda r: r.encode_seconds,
    ),
)

SOURCE: Final[tuple[Figure[Source], ...]] = (
    Figure("openrois_source_frames_total", "counter", "Frames taken from the source.", lambda s: s.frames),
    Figure(
        "openrois_source_last_frame_age_seconds",
        "gauge",
        "Time since the source gave its last frame.",
        lambda s: s.last_frame_age,
    ),
    Figure("openrois_source_encoders", "gauge", "Encoders of the source that run.", lambda s: s.encoders),
)

ADAPTER: Final[tuple[Figure[Process], ...]] = (
    Figure("openrois_sessions", "gauge", "Applications with a peer connection.", lambda p: p.sessions),
    Figure("openrois_sessions_limit", "gauge", "Applications that may have one.", lambda p: p.sessions_limit),
    Figure(
        "openrois_unanswered_sessions",
        "gauge",
        "Applications that have answered none of their offers yet.",
        lambda p: p.unanswered,
    ),
    Figure(
        "openrois_displaced_sessions_total",
        "counter",
        "Applications whose place was given to another one, because they had not answered an offer in time.",
        lambda p: p.displaced,
    ),
    Figure("openrois_tasks", "gauge", "Tasks of the event loop.", lambda p: p.tasks),
    Figure("openrois_threads", "gauge", "Threads of the process.", lambda p: p.threads),
)

VISITORS: Final[tuple[Figure[VisitorFigures], ...]] = (
    Figure("openrois_visitors", "gauge", "Applications that send the body microphone or camera.", lambda v: v.present),
    Figure("openrois_visitors_limit", "gauge", "Applications that may do so.", lambda _: MAX_VISITORS),
    Figure(
        "openrois_refused_visitors_total",
        "counter",
        "Streams of applications that were refused, because as many visitors sent as may.",
        lambda v: v.refused,
    ),
    Figure(
        "openrois_relayed_streams",
        "gauge",
        "Streams over which listeners receive what visitors send.",
        lambda v: v.relayed,
    ),
)

GUARD_LABELS: Final = ("reason",)

GUARD: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_guard_dropped_datagrams_total",
        "counter",
        "Datagrams dropped by the guard of media: unauthenticated, or unreadable.",
        lambda count: count,
    ),
)

STATUSES: Final = {
    "openrois_stream_status": (
        "Status of the stream, as in notify_stream_status.",
        tuple(status.value for status in StreamStatus),
    ),
    "openrois_source_status": (
        "Health of the source: component_status of the components that depend on it.",
        tuple(status.value.lower() for status in GRAVITY),
    ),
}
"""State sets: exactly one of the states is 1. Their labels are those of a stream and of a source."""
