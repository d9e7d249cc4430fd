"""A stream of an application: what it asked for and where it stands, and the table of all it has."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from openrois_signaling.messages import MediaKind

from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.errors import NoCommonCodec, UnknownStream
from openrois_streaming.feed import MediaPublisher
from openrois_streaming.liveness import Verdict
from openrois_streaming.state import OPEN, STATUS, StreamInput, StreamPhase, StreamStatus, following
from openrois_streaming.stats import Counters


def choose_codecs(kind: MediaKind, wanted: Sequence[str] | None) -> tuple[str, ...]:
    """The media types to offer for a stream.

    Args:
        kind: of the stream.
        wanted: what the application can decode, as media types ("video/VP8") or their subtypes ("VP8"), in any case.
            None if it did not say; then all that can be encoded here are offered, best first.

    Returns:
        The best of them by our own order alone, because it is the one that viewers can share.

    Raises:
        NoCommonCodec: none of `wanted` can be encoded here.
    """
    ours = [codec for codec in available_codecs() if codec.startswith(kind)]
    if wanted is not None:
        theirs = {name.lower().removeprefix(f"{kind}/") for name in wanted}
        ours = [codec for codec in ours if codec.lower().removeprefix(f"{kind}/") in theirs][:1]
    if not ours:
        raise NoCommonCodec(f"none of the {kind} codecs the application can decode can be sent")
    return tuple(ours)


@dataclass(slots=True, eq=False)
class Stream:
    """A stream that an application has connected. `codecs` are the media types it may be sent in, best first."""

    stream_id: str
    component_ref: str
    kind: MediaKind
    publisher: MediaPublisher
    codecs: tuple[str, ...]
    counters: Counters
    phase: StreamPhase = StreamPhase.CONNECTING

    @property
    def is_open(self) -> bool:
        """Whether it sends as soon as it can."""
        return self.phase in OPEN

    @property
    def status(self) -> StreamStatus:
        """What others are told."""
        return STATUS[self.phase]

    def apply(self, event: StreamInput) -> None:
        """Go on to the phase after `event`."""
        self.phase = following(self.phase, event)

    def judge(self, verdicts: Sequence[Verdict]) -> None:
        """Go on with what was measured on the media paths it has; one that flows is enough."""
        if not verdicts:
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

    The last change of each stream, and only that, has `ended`; its id is unknown from then on.
    """

    stream_id: str
    component_ref: str
    previous: StreamStatus
    status: StreamStatus
    at: float
    ended: bool = False

    @property
    def resumed(self) -> bool:
        """Whether this is the moment a suspended stream plays again."""
        return self.previous is StreamStatus.SUSPENDED and self.status is StreamStatus.RUNNING


class StreamTable:
    """The streams of one application, and what was told about each. Every change is told once, by `tell`."""

    def __init__(self, on_change: Callable[[StreamChange], None], clock: MediaClock) -> None:
        self._on_change = on_change
        self._clock = clock
        self._streams: dict[str, Stream] = {}
        self._told: dict[Stream, StreamStatus] = {}

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
            ended = stream.stream_id not in self._streams
            if ended:
                del self._told[stream]
            else:
                self._told[stream] = stream.status
            if ended or stream.status is not told:
                at = self._clock.wall()
                self._on_change(
                    StreamChange(stream.stream_id, stream.component_ref, told, stream.status, at, ended=ended)
                )
