"""A stream of an application: what it asked for and where it stands, and the table of all it has."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from openrois_signaling.messages import Direction, MediaKind

from openrois_streaming.adaptation.caps import Caps
from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.errors import NoCommonCodec, UnknownStream
from openrois_streaming.liveness import Verdict
from openrois_streaming.publish.rendition_feed import MediaPublisher
from openrois_streaming.source.uplink_sink import UplinkSelector
from openrois_streaming.state import OPEN, STATUS, Party, StreamInput, StreamPhase, StreamStatus, following, resumption
from openrois_streaming.stats import Counters


def choose_codecs(kind: MediaKind, wanted: Sequence[str] | None) -> tuple[str, ...]:
    """The media types to offer for a stream.

    Args:
        kind: of the stream.
        wanted: what the application can decode, and encode if it sends, as media types ("video/VP8") or their subtypes
            ("VP8"), in any case. None if it did not say; then all that can be had here are offered, best first.

    Returns:
        Those that both know, best first by our own order, because the best is the one that viewers can share.

    Raises:
        NoCommonCodec: none of `wanted` can be had here.
    """
    ours = [codec for codec in available_codecs() if codec.startswith(kind)]
    if wanted is not None:
        theirs = {name.lower().removeprefix(f"{kind}/") for name in wanted}
        ours = [codec for codec in ours if codec.lower().removeprefix(f"{kind}/") in theirs]
    if not ours:
        raise NoCommonCodec(f"none of the {kind} codecs of the application can be used here")
    return tuple(ours)


@dataclass(slots=True, eq=False)
class Stream:
    """A stream that an application has connected. `codecs` are the media types it is offered in, best first.

    `alternatives` are those that may take the place of one whose encoders fail; none for an application that did not
    say what it can decode, and may not know what a replacement is. `direction` is seen from the application.
    `publisher` is there where the application receives, `intake` where it sends. `caps` limit what it is sent.
    `stereo`: it is asked for two channels of sound.
    """

    stream_id: str
    component_ref: str
    kind: MediaKind
    publisher: MediaPublisher | None
    codecs: tuple[str, ...]
    counters: Counters
    direction: Direction = "recvonly"
    intake: UplinkSelector | None = None
    caps: Caps = field(default_factory=Caps)
    stereo: bool = False
    alternatives: tuple[str, ...] = ()
    path_bitrate: float | None = None
    """What its viewer's path was seen to carry, in bit/s; None if nothing is known yet."""
    playout_delay: float | None = None
    """Seconds from the arrival of its media to their being played, as its viewer said last; None if it never did."""
    phase: StreamPhase = StreamPhase.CONNECTING
    suspended_by: frozenset[Party] = frozenset()

    @property
    def is_open(self) -> bool:
        """Whether media passes as soon as it can."""
        return self.phase in OPEN

    @property
    def status(self) -> StreamStatus:
        """What others are told."""
        return STATUS[self.phase]

    def change_codec(self, played: str) -> bool:
        """Choose another codec where the one that is played cannot be encoded; tell whether there is one.

        It takes effect in the next peer connection. What was given up is not chosen again: nothing goes back and forth.
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
        """Go on to the phase after `event`."""
        self.phase = following(self.phase, event)

    def suspend(self, by: Party) -> None:
        """Nothing passes until `by` resumes it."""
        self.apply(StreamInput.SUSPEND)
        self.suspended_by |= {by}

    def resume(self, by: Party) -> None:
        """As far as `by` is concerned it goes on; it does so when nobody else has suspended it."""
        self.apply(resumption(self.suspended_by, by))
        self.suspended_by -= {by}
        if self.phase is StreamPhase.RESUMING and self.intake is not None:
            # Who has to send before anything is measured must hear of it before.
            self.apply(StreamInput.STALLED)

    def judge(self, verdicts: Sequence[Verdict]) -> None:
        """Go on with what was measured on the media paths it has; one that flows is enough."""
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
    """The status of a stream at `at`, in seconds since the epoch, is told because it changed or because it ended.

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
    """The streams of one application, and what was told about each. Every change is told once, by `tell`."""

    def __init__(self, on_change: Callable[[StreamChange], None], clock: MediaClock) -> None:
        self._on_change = on_change
        self._clock = clock
        self._streams: dict[str, Stream] = {}
        self._told: dict[Stream, StreamStatus] = {}
        self._paused: set[Stream] = set()
        """Those that were told suspended and not running since."""

    def __iter__(self) -> Iterator[Stream]:
        return iter(tuple(self._streams.values()))

    def __contains__(self, stream_id: str) -> bool:
        return stream_id in self._streams

    def __getitem__(self, stream_id: str) -> Stream:
        """The stream of that id. Raises UnknownStream."""
        try:
            return self._streams[stream_id]
        except KeyError:
            raise UnknownStream("there is no such stream") from None

    def report_playout(self, stream_id: str, seconds: float) -> None:
        """Note how long what arrives of a stream waits at its viewer until it is played. Raises UnknownStream."""
        self[stream_id].playout_delay = seconds

    def add(self, stream: Stream) -> None:
        """Take in a new stream."""
        self._streams[stream.stream_id] = stream
        self._told[stream] = stream.status

    def end(self, stream: Stream) -> None:
        """It is over, and unknown from now on."""
        stream.apply(StreamInput.END)
        del self._streams[stream.stream_id]

    def tell(self) -> None:
        """Tell every status that is not the one that was told last, and every end."""
        for stream, told in tuple(self._told.items()):
            if stream.stream_id not in self._streams:
                del self._told[stream]
                self._paused.discard(stream)
                self._on_change(self._change(stream, told, ended=True))
            elif stream.status is not told:
                self._told[stream] = stream.status
                resumed = stream.status is StreamStatus.RUNNING and stream in self._paused
                if stream.status is StreamStatus.SUSPENDED:
                    self._paused.add(stream)
                elif resumed:
                    self._paused.remove(stream)
                self._on_change(self._change(stream, told, resumed=resumed))

    def _change(
        self, stream: Stream, told: StreamStatus, *, ended: bool = False, resumed: bool = False
    ) -> StreamChange:
        at = self._clock.wall()
        return StreamChange(stream.stream_id, stream.component_ref, told, stream.status, at, ended, resumed)
