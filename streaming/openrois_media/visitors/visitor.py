"""One visitor: microphone and camera that one application sends, behind its consent."""

from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import aclosing, asynccontextmanager
from dataclasses import replace
from typing import Any, Final, Generic, TypeVar

from openrois_signaling.messages import MediaKind
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.fanout import DropOldest, Subscription
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.source.uplink_sink import UplinkSink

from openrois.aio.listeners import Listeners
from openrois.types.codes import Purpose
from openrois_media.uplinks import AudioUplink, VideoUplink
from openrois_media.visitors.consent import Consent

__all__ = ["DEVICES", "ConsentedSink", "ConsentedSource", "Visitor"]

DEVICES: Final[dict[MediaKind, str]] = {"video": "camera", "audio": "microphone"}
"""What a visitor sends each kind of media with."""

_WAITING: Final[dict[MediaKind, int]] = {"video": 1, "audio": 20}
"""Pictures and blocks of sound that may wait for a reader; the oldest makes room."""

Medium = TypeVar("Medium", bound=RawVideo | RawAudio)


class Visitor:
    """What one application sends to a body, and what may be done with it.

    Args:
        visitor_ref: its name for applications.
        clock: times consent; the clock of the capture times.

    Attributes:
        consent: what it consents to.
        withdrawn: called with what the visitor does not consent to any more.
        microphone: its sound as it comes; read it by `source`.
        camera: its pictures, likewise.
    """

    def __init__(self, visitor_ref: str, clock: MediaClock) -> None:
        self.visitor_ref = visitor_ref
        self.consent = Consent()
        self.withdrawn: Listeners[frozenset[Purpose]] = Listeners()
        self.microphone, self.camera = AudioUplink("microphone of a visitor"), VideoUplink("camera of a visitor")
        self.states_consent = False
        """Whether it says itself what it consents to; else that is assumed."""
        self._clock = clock
        self._sinks: dict[str, ConsentedSink] = {}

    @property
    def is_present(self) -> bool:
        """Whether it sends anything, suspended or not."""
        return bool(self._sinks)

    def sends(self, kind: MediaKind) -> bool:
        """Tell whether it has a microphone (`audio`) or a camera (`video`) that can be attended to."""
        return any(sink.target is self.inlet(kind) for sink in self._sinks.values())

    def inlet(self, kind: MediaKind) -> SharedInlet[Any]:
        """Return the inlet of a kind of media."""
        return self.camera if kind == "video" else self.microphone

    def state(self, purposes: frozenset[Purpose]) -> None:
        """Consent to these purposes, and to no other, from now on."""
        withdrawn = self.consent.state(purposes, self._clock.now())
        for sink in self._sinks.values():
            sink.follow()
        if withdrawn:
            self.withdrawn.notify_all(withdrawn)

    def add(self, stream_id: str, sink: "ConsentedSink") -> None:
        """Note a stream that it sends."""
        self._sinks[stream_id] = sink

    def has(self, stream_id: str) -> bool:
        """Tell whether it sends this stream."""
        return stream_id in self._sinks

    def remove(self, stream_id: str) -> bool:
        """Forget a stream that has ended; whether it was one of this visitor's."""
        return self._sinks.pop(stream_id, None) is not None

    def leave(self) -> None:
        """Forget all that it sends, and its consent: to what it sends next it consents anew."""
        self.state(frozenset())
        self.states_consent = False
        self._sinks.clear()

    def source(self, kind: MediaKind, purposes: frozenset[Purpose], *, for_any: bool = False) -> "ConsentedSource[Any]":
        """Return the media of a kind for a reader with these purposes, one at least.

        Args:
            kind: "audio" or "video".
            purposes: what the reader uses it for.
            for_any: whether the consent to one of them is enough: the reader passes each item on to those alone for
                which it is admitted.
        """
        return ConsentedSource(self, kind, purposes, for_any=for_any)


class ConsentedSink:
    """Sink of one stream: what it takes goes on to `target` while the visitor consents to something it is for.

    Args:
        visitor: the sender.
        target: the inlet of the body that its media goes to.
        purpose: what that is for; None for an inlet whose readers each have purposes of their own.
    """

    def __init__(self, visitor: Visitor, target: UplinkSink, purpose: Purpose | None) -> None:
        self.visitor = visitor
        self.target = target
        self._purpose = purpose
        self._plugged: tuple[str, MediaSource[Any]] | None = None
        self._offered: tuple[str, MediaSource[Any]] | None = None

    def plug(self, stream_id: str, source: MediaSource[Any]) -> None:
        """Take media from `source` from now on."""
        self._offered = stream_id, source
        self.follow()

    def unplug(self, stream_id: str) -> None:
        """Take no more media."""
        if self._offered is not None and self._offered[0] == stream_id:
            self._offered = None
            self.follow()

    def follow(self) -> None:
        """Pass media on, or not, by the present consent: without any nothing is decoded."""
        consent = self.visitor.consent
        allowed = bool(consent.purposes) if self._purpose is None else consent.holds({self._purpose})
        wanted = self._offered if allowed else None
        if wanted is self._plugged:
            return
        before, self._plugged = self._plugged, wanted
        if wanted is not None:
            stream_id, source = wanted
            self.target.plug(stream_id, source if self._purpose is None else _Since(source, self._admits))
        elif before is not None:
            self.target.unplug(before[0])

    def _admits(self, item: Any) -> bool:
        assert self._purpose is not None, "only what has one purpose is judged here"
        return self.visitor.consent.admits({self._purpose}, item.captured_at)


class _Since(Generic[Medium]):
    """Media of a source, without what was captured before the consent to it."""

    def __init__(self, source: MediaSource[Medium], admits: Callable[[Medium], bool]) -> None:
        self._source = source
        self._admits = admits

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[Medium]]:
        """Open the source for as long as the context lasts."""
        async with self._source.open() as items, aclosing(self._admitted(items)) as admitted:
            yield admitted

    async def _admitted(self, items: AsyncIterator[Medium]) -> AsyncGenerator[Medium, None]:
        async for item in items:
            if self._admits(item):
                yield item


class ConsentedSource(Generic[Medium]):
    """Media of a visitor for some purposes, a `MediaSource` of any number of readers, each open on its own.

    It gives nothing while the visitor does not consent to all of the purposes. At a withdrawal what waits is dropped.
    Each item names the visitor as its `sender`.

    Args:
        visitor: the sender.
        kind: of media.
        purposes: what the reader uses it for.
        for_any: whether the consent to one of them is enough.
    """

    def __init__(
        self, visitor: Visitor, kind: MediaKind, purposes: frozenset[Purpose], *, for_any: bool = False
    ) -> None:
        self.kind = kind
        self.purposes = purposes
        self._visitor = visitor
        self._alternatives = [frozenset({each}) for each in purposes] if for_any else [purposes]

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[Medium]]:
        """Read for as long as the context lasts."""
        visitor = self._visitor
        mailbox = _Admitted[Medium](self._admits, _WAITING[self.kind])
        leave = visitor.withdrawn.add(lambda gone: mailbox.clear() if gone & self.purposes else None)
        try:
            async with (
                visitor.inlet(self.kind).subscribe(mailbox=mailbox) as waiting,
                aclosing(self._named(waiting)) as items,
            ):
                yield items
        finally:
            leave()

    def _admits(self, item: Medium) -> bool:
        consent = self._visitor.consent
        return any(consent.admits(each, item.captured_at) for each in self._alternatives)

    async def _named(self, waiting: Subscription[Medium]) -> AsyncGenerator[Medium, None]:
        while True:
            yield replace(await waiting.get(), sender=self._visitor.visitor_ref)


class _Admitted(DropOldest[Medium]):
    """Mailbox that takes what its reader may have, and can be emptied."""

    __slots__ = ("_admits",)

    def __init__(self, admits: Callable[[Medium], bool], maxsize: int) -> None:
        super().__init__(maxsize)
        self._admits = admits

    def put(self, item: Medium) -> int:
        """Append an item that is admitted; another one is not even lost."""
        return super().put(item) if self._admits(item) else 0

    def clear(self) -> None:
        """Drop what waits."""
        self._items.clear()
