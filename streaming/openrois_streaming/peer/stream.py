"""Stream of an application: its request and its phase, and the table of all streams."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from openrois_signaling.messages import Direction, MediaKind

from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.errors import NoCommonCodec, UnknownStream
from openrois_streaming.liveness import Verdict
from openrois_streaming.publish.rendition_feed import MediaPublisher
from openrois_streaming.source.uplink_sink import UplinkSelector
from openrois_streaming.state import OPEN, STATUS, Party, StreamInput, StreamPhase, StreamStatus, following, resumption
from openrois_streaming.stats import Counters


def choose_codecs(kind: MediaKind, wanted: Sequence[str] | None) -> tuple[str, ...]:
    """Return the media types to offer for a stream.

    Args:
        kind: of the stream.
        wanted: codecs that the application can decode, and encode if it sends, as media types ("video/VP8") or their
            subtypes ("VP8"), in any case. None if it named none; then all available ones are offered, best first.

    Returns:
        Those that both know, best first by our order, so that viewers share the best one.

    Raises:
        NoCommonCodec: none of `wanted` is available here.
    """
    known = ours = [codec for codec in available_codecs() if codec.startswith(kind)]
    if wanted is not None:
        theirs = {name.lower().removeprefix(f"{kind}/") for name in wanted}
        ours = [codec for codec in ours if codec.lower().removeprefix(f"{kind}/") in theirs]
    if not ours:
        raise NoCommonCodec(f"the application names no {kind} codec of this engine: {', '.join(known)}")
    return tuple(ours)


@dataclass(slots=True, eq=False)
class Stream:
    """Stream that an application has connected. `codecs` are the media types it is offered in, best first.

    `alternatives` may replace a codec whose encoders fail; there are none for an application that named no codecs, and
    may not know peer replacement. `direction` is seen from the application. `publisher` is set where the application
    receives, `uplink_selector` where it sends. `caps` limit what it is sent. `stereo` asks it for two channels of
    sound.
    """

    stream_id: str
    component_ref: str
    kind: MediaKind
    publisher: MediaPublisher | None
    codecs: tuple[str, ...]
    counters: Counters
    direction: Direction = "recvonly"
    uplink_selector: UplinkSelector | None = None
    caps: Caps = field(default_factory=Caps)
    stereo: bool = False
    alternatives: tuple[str, ...] = ()
    path_bitrate: float | None = None
    """Bit/s that its viewer's path was measured to carry; None before any measurement."""
    playout_delay: float | None = None
    """Seconds from the arrival of media until it is played, as last reported by the viewer; None without a report."""
    phase: StreamPhase = StreamPhase.CONNECTING
    suspended_by: frozenset[Party] = frozenset()

    @property
    def is_open(self) -> bool:
        """Whether media passes as soon as it can."""
        return self.phase in OPEN

    @property
    def status(self) -> StreamStatus:
        """Status of which the application is notified."""
        return STATUS[self.phase]

    def change_codec(self, played: str) -> bool:
        """Choose another codec if the played one cannot be encoded; whether there is one.

        It takes effect in the next peer connection. A failed codec is not chosen again, so that codecs do not
        alternate.
        """
        publisher = self.publisher
        if publisher is None or not self.is_open or publisher.can_encode(played):
            return False
        left = tuple(each for each in self.alternatives if each != played)
        other = next((each for each in left if publisher.can_encode(each) and publisher.has_room(each)), None)
        if other is None:
            return False
        self.alternatives, self.codecs = left, (other,)
        return True

    def apply(self, event: StreamInput) -> None:
        """Change to the phase after `event`."""
        self.phase = following(self.phase, event)

    def suspend(self, by: Party) -> None:
        """Suspend the stream until `by` resumes it."""
        self.apply(StreamInput.SUSPEND)
        self.suspended_by |= {by}

    def resume(self, by: Party) -> None:
        """Resume the stream for `by`; it goes on when no other party suspends it."""
        self.apply(resumption(self.suspended_by, by))
        self.suspended_by -= {by}
        if self.phase is StreamPhase.RESUMING and self.uplink_selector is not None:
            # An application that has to send before media is measured must be notified first.
            self.apply(StreamInput.STALLED)

    def judge(self, verdicts: Sequence[Verdict]) -> None:
        """Apply the judgements on its media paths; one that flows is enough."""
        if not verdicts or (self.phase is StreamPhase.RUNNING and Verdict.FLOWING in verdicts):
            return
        self.apply(StreamInput.UP)
        if not self.is_open:
            return
        if Verdict.FLOWING in verdicts:
            self.apply(StreamInput.FLOWING)
        elif all(verdict is Verdict.STALLED for verdict in verdicts):
            self.apply(StreamInput.STALLED)


@dataclass(frozen=True, slots=True)
class StreamChange:
    """Change of the status of a stream, or its end, at `at` (epoch seconds).

    The last change of each stream, and only that, has `ended`; its id is unknown from then on. `resumed` is the first
    RUNNING after a suspension.
    """

    stream_id: str
    component_ref: str
    previous: StreamStatus
    status: StreamStatus
    at: float
    ended: bool = False
    resumed: bool = False


class StreamTable:
    """Streams of one application. Every change is notified once, by `notify_changes`."""

    def __init__(self, on_change: Callable[[StreamChange], None], clock: MediaClock) -> None:
        self._on_change = on_change
        self._clock = clock
        self._streams: dict[str, Stream] = {}
        self._notified: dict[Stream, StreamStatus] = {}
        self._paused: set[Stream] = set()
        """Streams notified as suspended and not as running since."""

    def __iter__(self) -> Iterator[Stream]:
        return iter(tuple(self._streams.values()))

    def __contains__(self, stream_id: str) -> bool:
        return stream_id in self._streams

    def __getitem__(self, stream_id: str) -> Stream:
        """Return the stream of that id. Raises UnknownStream."""
        try:
            return self._streams[stream_id]
        except KeyError:
            raise UnknownStream("there is no such stream") from None

    def report_playout(self, stream_id: str, seconds: float) -> None:
        """Note the playout delay of a stream at its viewer, in seconds. Raises UnknownStream."""
        self[stream_id].playout_delay = seconds

    def add(self, stream: Stream) -> None:
        """Add a new stream."""
        self._streams[stream.stream_id] = stream
        self._notified[stream] = stream.status

    def end_stream(self, stream: Stream) -> None:
        """End a stream, which is unknown from now on."""
        stream.apply(StreamInput.END)
        del self._streams[stream.stream_id]

    def notify_changes(self) -> None:
        """Notify every change of a status since the last notification, and every end."""
        for stream, previous in tuple(self._notified.items()):
            if stream.stream_id not in self._streams:
                del self._notified[stream]
                self._paused.discard(stream)
                self._on_change(self._change(stream, previous, ended=True))
            elif stream.status is not previous:
                self._notified[stream] = stream.status
                resumed = stream.status is StreamStatus.RUNNING and stream in self._paused
                if stream.status is StreamStatus.SUSPENDED:
                    self._paused.add(stream)
                elif resumed:
                    self._paused.remove(stream)
                self._on_change(self._change(stream, previous, resumed=resumed))

    def _change(
        self, stream: Stream, previous: StreamStatus, *, ended: bool = False, resumed: bool = False
    ) -> StreamChange:
        at = self._clock.wall()
        return StreamChange(stream.stream_id, stream.component_ref, previous, stream.status, at, ended, resumed)
