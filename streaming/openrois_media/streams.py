"""Streams of an adapter: a component, a publisher and a judge of health for each of its sources."""

from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from functools import partial
from types import TracebackType
from typing import TypeAlias

from openrois_signaling.messages import MediaKind
from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.capture.audio import AudioSource
from openrois_streaming.capture.given import source_remedy
from openrois_streaming.capture.video import EncodedSource, VideoSource
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publish.encoder_limit import EncoderLimit
from openrois_streaming.publish.passthrough import EncodedPublisher
from openrois_streaming.publish.publisher import AudioPublisher, Publishing, VideoPublisher

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_media.channel_sinks import OperatorInput, SpeechInput
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.health import Health, worst
from openrois_media.metrics.collector import Collector
from openrois_media.metrics.figures import FigureGroup
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_media.supervision import Supervised, seen_of, supervise
from openrois_media.uplinks import AudioUplink, VideoUplink
from openrois_media.visitors.registry import VisitorRegistry, VisitorUplink

__all__ = ["AdapterStreams", "Source", "Stream", "codecs_of"]

Source: TypeAlias = VideoSource | EncodedSource | AudioSource
"""What a body shows or sounds."""


@dataclass(frozen=True, slots=True)
class Stream:
    """One streaming component of an adapter: what it gives, what it takes, or both.

    Attributes:
        source: what applications see or hear; a publisher if it encodes by its own rule; None if they only send.
        uplink: takes what one application sends, or what every visitor does (of a `VisitorRegistry`); None if they only
            receive. Of the same kind as the source.
        label: its name in metrics and sentences; the component's unless given.
        status: returns the status of what its source is a part of; None: nothing else can fail.
    """

    source: Source | Publishing | None = None
    uplink: VideoUplink | AudioUplink | VisitorUplink | None = None
    label: str = ""
    status: Callable[[], ComponentStatus] | None = None

    @property
    def kind(self) -> MediaKind:
        """Kind of its media.

        Raises:
            ValueError: it has neither a source nor an uplink, or they are of different kinds.
        """
        kinds = {part.kind for part in (self.source, self.uplink) if part is not None}
        if len(kinds) != 1:
            found = " and ".join(sorted(kinds)) or "neither"
            raise ValueError(f"a stream has a source, an uplink, or both of one kind of media, not {found}")
        return kinds.pop()


class AdapterStreams:
    """Streams of one adapter, for `openrois.adapter.serve(*streams.components.values(), extension=streams)`.

    Each source has a component of its name. All sources share one limit on encoders, and one on applications. While the
    context lasts, the streams are served and the health of their sources is judged.

    Args:
        engine_id: leads every ref.
        streams: by the names of their components.
        clock: the media clock of the sources; this machine's if not given.
        network: how the streams use the network.
        cap: returns the limits of a client's streams; None: as much as its path carries.
        encoders: limit on the encoders of all sources.
        operator: input of the operator; None: the body cannot be operated by hand.
        speech: speech as sound, or what refuses it; None: it is refused.

    Attributes:
        components: the streaming components, by name.
        publishers: the publishers, by label.
        interface: answers the calls of applications.
        supervised: what is judged, by label: the sources, and what the adapter adds before it enters.

    Raises:
        BadParameter: a name cannot be part of a reference.
        TypeError: what is to be streamed is no source.
        ValueError: a stream has nothing to stream, or two kinds of media; or two have one source, uplink or label.
        UnsupportedLibrary: (on entering) the installed version of aiortc is not supported.
    """

    def __init__(
        self,
        engine_id: str,
        streams: Mapping[str, Source | Stream],
        *,
        clock: MediaClock | None = None,
        network: NetworkSettings | None = None,
        cap: Callable[[Client], Caps] | None = None,
        encoders: EncoderLimit | None = None,
        operator: OperatorInput | None = None,
        speech: SpeechInput | None = None,
    ) -> None:
        self._clock = clock or SystemClock()
        self._encoders = encoders or EncoderLimit()
        self.components: dict[str, VideoStreaming | AudioStreaming] = {}
        self.publishers: dict[str, Publishing] = {}
        self.supervised: dict[str, Supervised] = {}
        _check_distinct(streams)
        published = {reference(engine_id, name): self._add(name, each) for name, each in streams.items()}
        self.interface = StreamingInterface(
            engine_id, published, self._clock, network, cap, operator, speech, _visitors_of(streams)
        )
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> StreamingInterface:
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self.interface.sessions)
            tasks = await stack.enter_async_context(TaskScope())
            tasks.start(supervise(tuple(self.supervised.values()), self._clock))
            self._stack = stack.pop_all()
        return self.interface

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    def collector(self, more: Callable[[], tuple[FigureGroup, ...]] = tuple) -> Collector:
        """Return a collector of the figures of all streams, and of what `more` returns."""
        interface = self.interface
        return Collector(
            interface.sessions,
            self.publishers,
            self.supervised,
            interface.guarded,
            self._clock,
            more,
            interface.visitor_figures,
        )

    def _add(self, name: str, source: Source | Stream) -> Published:
        stream = source if isinstance(source, Stream) else Stream(source)
        label = stream.label or name
        publisher = None if stream.source is None else self._publisher(stream.source, label)
        available = _any_codec if publisher is None else publisher.codecs
        published = Published(publisher, stream.kind, stream.uplink, available)
        health = Health(f"the {label}", self._clock.now())
        others = stream.status

        def status() -> ComponentStatus:
            return health.status if others is None else worst(others(), health.status)

        codecs = _codecs_of_kind(stream.kind) if publisher is None else codecs_of(publisher)
        make = VideoStreaming if stream.kind == "video" else AudioStreaming
        component = self.components[name] = make(codecs, published.directions, status, name)
        if publisher is not None:
            self.publishers[label] = publisher
            self.supervised[label] = Supervised(health, partial(seen_of, publisher), (component,))
        return published

    def _publisher(self, source: Source | Publishing, label: str) -> Publishing:
        clock = self._clock
        match source:
            case VideoSource(frame_rate=frame_rate, size=size):
                return VideoPublisher(
                    source, clock=clock, frame_rate=frame_rate, size=size, encoders=self._encoders, name=label
                )
            case EncodedSource(frame_rate=frame_rate, size=size, mime_type=mime_type):
                return EncodedPublisher(
                    source, clock=clock, mime_type=mime_type, frame_rate=frame_rate, size=size, name=label
                )
            case AudioSource():
                return AudioPublisher(source, clock=clock, name=label)
            case _ if hasattr(source, "renditions"):
                return source
        raise TypeError(f"{label} is a {type(source).__name__} and no source: {source_remedy(source)}")


def _check_distinct(streams: Mapping[str, Source | Stream]) -> None:
    """Check that no two streams share what only one can have."""
    seen: dict[object, str] = {}
    for name, each in streams.items():
        stream = each if isinstance(each, Stream) else Stream(each)
        for kind, part, remedy in (
            ("source", stream.source, "a source is open once, so name it once"),
            ("uplink", stream.uplink, "make one for each"),
        ):
            if part is not None and (other := seen.setdefault(id(part), name)) != name:
                raise ValueError(f"{name} and {other} have one {kind}: {remedy}")
        label = stream.label or name
        if label in seen:
            raise ValueError(f"{label!r} is the label of two streams: give each its own")
        seen[label] = name


def _visitors_of(streams: Mapping[str, Source | Stream]) -> VisitorRegistry | None:
    """Return the visitors whose uplinks are among the streams; None where there are no such uplinks."""
    uplinks = [each.uplink for each in streams.values() if isinstance(each, Stream)]
    found = {uplink.visitors for uplink in uplinks if isinstance(uplink, VisitorUplink)}
    if len(found) > 1:
        raise ValueError("the streams take the visitors of several registries: make one VisitorRegistry for all")
    return found.pop() if found else None


def codecs_of(publisher: Publishing) -> tuple[str, ...]:
    """Return the media types that a publisher has now, best first."""
    return publisher.codecs() or _codecs_of_kind(publisher.kind)


def _codecs_of_kind(kind: MediaKind) -> tuple[str, ...]:
    return tuple(each for each in available_codecs() if each.startswith(f"{kind}/"))


def _any_codec() -> None:
    """Return None: what applications send may have any codec that is known here."""
