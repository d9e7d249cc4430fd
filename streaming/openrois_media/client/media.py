"""Media of an application: pictures and sound of components, and its own camera and microphone."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Collection, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Final, Literal, Self, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray
from openrois_signaling.messages import MediaKind
from openrois_streaming.capture.given import is_source, source_remedy
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.input.speech import RATES, SpeechFormat
from openrois_streaming.receive.decoded import DecodedPicture
from openrois_streaming.recording.jpeg import jpeg_of
from openrois_streaming.source.av_frames import FrameFormat
from openrois_streaming.source.source import SAMPLE_RATE, MediaSource, RawAudio, RawVideo

from openrois.aio.tasks import TaskScope
from openrois.client import Client, ComponentProxy
from openrois.types.codes import Purpose, StreamStatus
from openrois.types.references import engine_of
from openrois_media.client.destinations import STREAMING_TYPES, find_carrier, find_speaker, find_uplink
from openrois_media.client.readers import Block, Frame, StreamReader, block_of, frame_of
from openrois_media.client.sending import Sending, consenting
from openrois_media.client.speaking import Speaking
from openrois_media.client.stream import (
    AUDIO_BLOCKS,
    NOTHING_MORE,
    CarrierStream,
    ClientStream,
    ReceivedStream,
    SentStream,
)
from openrois_media.client.stream_state import Desire
from openrois_media.client.streams import Streams
from openrois_media.client.visitors import Visitor, VisitorCamera, VisitorDevice, VisitorMicrophone, read_visitors

__all__ = ["Media"]

CONNECT_TIMEOUT: Final = 10.0
"""Default seconds that connecting a stream, or taking a snapshot, may take."""

SNAPSHOT_AGE: Final = 1.0
"""Seconds that may have passed since a snapshot was captured."""

_SENDER_CLOCK: Final = 3.0
"""Seconds for which the first report of a sender is waited for, which tells its clock; half of the time at most."""

_METHODS: Final[dict[MediaKind, str]] = {"video": "frames", "audio": "blocks"}

T = TypeVar("T")

_Key: TypeAlias = tuple[str, MediaKind, str]
"""What a stream is known by: its component, its kind, and what else was asked for."""


@dataclass(eq=False)
class _Shared:
    """A received stream and its readers."""

    stream: ReceivedStream
    key: _Key
    readers: list[StreamReader[Any]] = field(default_factory=list)
    users: int = 0

    def follow(self) -> None:
        """Run the stream while a reader wants it to."""
        runs = any(reader.desire is Desire.RUNNING for reader in self.readers)
        desire = Desire.RUNNING if runs or not self.readers else Desire.SUSPENDED
        if desire is not self.stream.state.desire:
            self.stream.want(desire)


class Media:
    """Pictures and sound of components, and what an application sends them: `async with Media(client) as media`.

    Readers of one component share one stream and one decoder; it is decoded only while it is read, and disconnected
    when its last reader has left. What is lost with the gateway, an adapter or the network is connected again, and a
    suspended stream comes back suspended.

    Args:
        client: an open client; it must stay open for as long as the block runs.
        clock: the clock of `local_time` and of all waits; this machine's unless given.
    """

    def __init__(self, client: Client, *, clock: MediaClock | None = None) -> None:
        self._client = client
        self._clock = clock or SystemClock()
        self._stack = AsyncExitStack()
        self._streams: Streams | None = None
        self._shared: dict[_Key, _Shared] = {}

    async def __aenter__(self) -> Self:
        self._streams = await self._stack.enter_async_context(Streams(self._client, self._clock))
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disconnect every stream and close every peer connection."""
        for shared in self._shared.values():
            shared.stream.end_frames()
        self._streams = None
        await self._stack.aclose()

    @asynccontextmanager
    async def frames(
        self,
        camera: str | ComponentProxy | VisitorDevice,
        format: FrameFormat = "rgb24",
        *,
        timeout: float = CONNECT_TIMEOUT,
    ) -> AsyncIterator[StreamReader[Frame]]:
        """Yield the pictures of a component, the newest one at each step: `async for frame in frames`.

        Args:
            camera: a component with a stream of pictures, such as VideoStreaming, or its reference; or a visitor's.
            format: how the pixels come: `rgb24`, `bgr24`, or `i420`, which costs least.
            timeout: seconds that connecting the stream may take.

        Raises:
            ValueError: there is no such format, or the component has no pictures.
            RoISError: the engine refuses.
            TimeoutError: it is not connected in time.
        """
        _require_format(format)
        async with self._reading(camera, "video", 1, lambda picture: frame_of(picture, format), timeout) as reader:
            yield reader

    @asynccontextmanager
    async def blocks(
        self, microphone: str | ComponentProxy | VisitorDevice, *, timeout: float = CONNECT_TIMEOUT
    ) -> AsyncIterator[StreamReader[Block]]:
        """Yield the sound of a component without a break, in blocks: `async for block in blocks`.

        Lost sound is concealed. A reader that is slow loses the oldest when a second of sound waits.

        Args:
            microphone: a component with a stream of sound, such as AudioStreaming, or its reference; or that of a
                visitor.
            timeout: seconds that connecting the stream may take.

        Raises:
            ValueError: the component has no sound.
            RoISError: the engine refuses.
            TimeoutError: it is not connected in time.
        """
        async with self._reading(microphone, "audio", AUDIO_BLOCKS, block_of, timeout) as reader:
            yield reader

    @overload
    async def snapshot(
        self,
        camera: str | ComponentProxy | VisitorDevice,
        format: Literal["jpeg"] = "jpeg",
        *,
        timeout: float = CONNECT_TIMEOUT,
    ) -> bytes: ...
    @overload
    async def snapshot(
        self, camera: str | ComponentProxy | VisitorDevice, format: FrameFormat, *, timeout: float = CONNECT_TIMEOUT
    ) -> NDArray[np.uint8]: ...
    async def snapshot(
        self,
        camera: str | ComponentProxy | VisitorDevice,
        format: Literal["jpeg"] | FrameFormat = "jpeg",
        *,
        timeout: float = CONNECT_TIMEOUT,
    ) -> bytes | NDArray[np.uint8]:
        """Return one picture of a component, captured a second ago at most.

        For several pictures keep `frames` open: a stream is connected for each snapshot that finds none. Of a new
        stream the sender's clock is known with its first report, within a second usually; that is waited for.

        Args:
            camera: as in `frames`.
            format: `jpeg` for the bytes of a JPEG file, or a pixel format of `frames` for an array as `Frame.data`.
            timeout: seconds that it may take in all.

        Raises:
            ValueError: there is no such format, or the component has no pictures.
            RoISError: the engine refuses.
            TimeoutError: no picture comes in time; the text says what is wrong.
        """
        if format not in ("jpeg", "i420", "rgb24", "bgr24"):
            raise ValueError(f"{format!r} is not a format of snapshots: use jpeg, i420, rgb24 or bgr24")
        picture = await self._new_picture(camera, timeout)
        return jpeg_of(picture.raw()) if format == "jpeg" else picture.pixels(format).copy()

    async def new_frame(
        self,
        camera: str | ComponentProxy | VisitorDevice,
        format: FrameFormat = "rgb24",
        *,
        timeout: float = CONNECT_TIMEOUT,
    ) -> Frame:
        """Return a snapshot with its times.

        Its `captured_at` is None where the sender tells no clock: then its age is an estimate.

        Args:
            camera: as in `frames`.
            format: as in `frames`.
            timeout: seconds that it may take in all.

        Raises:
            ValueError, RoISError, TimeoutError: as `snapshot`.
        """
        _require_format(format)
        return frame_of(await self._new_picture(camera, timeout), format)

    async def _new_picture(self, camera: str | ComponentProxy | VisitorDevice, timeout: float) -> DecodedPicture:
        deadline = self._clock.now() + timeout
        async with self._reading(camera, "video", 1, _as_it_is, timeout) as reader:
            told = ""
            try:
                async with asyncio.timeout(max(deadline - self._clock.now(), 0.0)):
                    picture: DecodedPicture = await anext(reader)
                    now = self._clock.now()
                    clock_until = now + min(_SENDER_CLOCK, (deadline - now) / 2)
                    while not _is_new(picture, self._clock.now(), clock_until):
                        told = f"its pictures are older than {SNAPSHOT_AGE:g} s"
                        picture = await anext(reader)
                    return picture
            except TimeoutError:
                told = reader.problem or told or f"its stream is {_said(reader.status)}"
                raise TimeoutError(f"{reader.component_ref} gave no picture within {timeout:g} s: {told}") from None
            except StopAsyncIteration:
                raise TimeoutError(f"{reader.component_ref} gave no picture: the client is closed") from None

    async def visitors(self, body: str | ComponentProxy, *, purposes: Collection[Purpose]) -> tuple[Visitor, ...]:
        """Return the visitors of a body, with microphone and camera of each for these purposes.

        Where the gateway asks for tokens, the role listener is needed to receive them, and consent of the visitor to
        every purpose.

        Args:
            body: its engine id, or any component of it, or its reference.
            purposes: all that this application uses their sound and pictures for, one at least.

        Raises:
            ValueError: there is no purpose.
            Unsupported: the body tells no visitors apart.
            RoISError: the engine did not answer.
        """
        self._require_open()
        if not purposes:
            raise ValueError("say what the media of visitors are for: give one purpose at least")
        text = body if isinstance(body, str) else body.component_ref
        engine_id = engine_of(text) or text
        present = await read_visitors(self._client, engine_id)
        uplinks: dict[MediaKind, str] = (
            {kind: await find_uplink(self._client, kind, engine_id) for kind in ("audio", "video")} if present else {}
        )
        return tuple(
            Visitor(
                **each,
                microphone=VisitorMicrophone(uplinks["audio"], each["visitor_ref"], frozenset(purposes), self),
                camera=VisitorCamera(uplinks["video"], each["visitor_ref"], frozenset(purposes), self),
            )
            for each in present
        )

    @asynccontextmanager
    async def send(
        self,
        *,
        camera: MediaSource[RawVideo] | None = None,
        microphone: MediaSource[RawAudio] | None = None,
        consent: Collection[Purpose] | None = None,
        to: str | ComponentProxy | None = None,
        timeout: float = CONNECT_TIMEOUT,
    ) -> AsyncIterator[Sending]:
        """Send pictures, sound or both to a body, for as long as the block runs.

        Where the gateway asks for tokens, the role visitor is needed, and consent to something; or an actuation
        component of the body has to be bound, as for operating it.

        Args:
            camera: source of the pictures, open while they can be sent.
            microphone: source of the sound, likewise.
            consent: all that they may be used for; None to leave it at live and recognition.
            to: any component of the body; needed where several bodies take what applications send.
            timeout: seconds that connecting may take.

        Raises:
            ValueError: there is nothing to send.
            TypeError: what is to be sent is no source.
            Unsupported: no component takes it.
            BadParameter: several do.
            RoISError: the engine refuses, such as OutOfResources without control.
            TimeoutError: it is not connected in time.
        """
        streams = self._require_open()
        sources: dict[MediaKind, MediaSource[Any] | None] = {"video": camera, "audio": microphone}
        if camera is None and microphone is None:
            raise ValueError("there is nothing to send: give a camera, a microphone or both")
        for name, source in (("camera", camera), ("microphone", microphone)):
            if source is not None and not is_source(source):
                raise TypeError(f"{name} is a {type(source).__name__} and no source: {source_remedy(source)}")
        stated = NOTHING_MORE if consent is None else consenting(consent)
        sent = [
            SentStream(await find_uplink(self._client, kind, to), kind, source, streams, self._clock, stated)
            for kind, source in sources.items()
            if source is not None
        ]
        async with AsyncExitStack() as stack:
            tasks = await stack.enter_async_context(TaskScope())
            for stream in sent:
                streams.add(stream)
                stack.push_async_callback(streams.remove, stream)
                stream.want(Desire.RUNNING)
            for stream in sent:
                await _established(stream, timeout)
                tasks.start(stream.run_source())
            yield Sending(sent, self._client)

    @asynccontextmanager
    async def speech(
        self,
        to: str | ComponentProxy | None = None,
        *,
        rate: int = SAMPLE_RATE,
        format: SpeechFormat = "pcm16",
        timeout: float = CONNECT_TIMEOUT,
    ) -> AsyncIterator[Speaking]:
        """Speak by sound through a body: `await speech.push(samples)`, `await speech.finish()`.

        Its component SpeechStream is bound for as long as the block runs. The block ends when all was heard that was
        pushed; where it fails or is cancelled the body falls silent.

        Args:
            to: any component of the body, or its engine id; needed where several bodies speak by sound.
            rate: samples a second of what will be pushed: 16000, 24000 or 48000.
            format: how it is sent: `pcm16` as it is, `opus` with a tenth of the bits, at 48000.
            timeout: seconds that connecting may take.

        Raises:
            ValueError: there is no such rate or format.
            Unsupported: no component speaks by sound.
            BadParameter: several do.
            OutOfResources: another application has it.
            RoISError: the engine refuses.
            TimeoutError: it is not connected in time.
        """
        streams = self._require_open()
        if format not in ("pcm16", "opus") or rate not in RATES or (format == "opus" and rate != SAMPLE_RATE):
            raise ValueError(
                f"{format!r} at {rate!r} Hz is not possible: use pcm16 at 16000, 24000 or 48000, or opus at 48000"
            )
        speaker = await find_speaker(self._client, to)
        carrier = CarrierStream(*await find_carrier(self._client, speaker.component_ref), streams, self._clock)
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(speaker.bound())
            streams.add(carrier)
            stack.push_async_callback(streams.remove, carrier)
            carrier.want(Desire.SUSPENDED)
            await _established(carrier, timeout)
            await _opened(carrier, timeout)
            # What the adapter is asked behind the binding it answers when it knows of that.
            await speaker.query("streaming")
            speeches = streams.speeches
            speaking = Speaking(
                speaker.component_ref,
                rate,
                format,
                lambda begin, speaking: speeches.begin_speech(begin, speaking, carrier),
                speeches.next_number,
            )
            try:
                yield speaking
                await speaking.finish_all()
            finally:
                speaking.close()

    @asynccontextmanager
    async def _reading(
        self,
        component: str | ComponentProxy | VisitorDevice,
        kind: MediaKind,
        waiting: int,
        convert: Callable[[Any], T],
        timeout: float,
    ) -> AsyncIterator[StreamReader[T]]:
        transport = NOTHING_MORE
        if isinstance(component, VisitorDevice):
            if component.kind != kind:
                raise ValueError(f"a visitor's {component.name} has {component.kind}, not {kind}")
            component_ref, transport = component.component_ref, component.transport
        else:
            component_ref = await self._require_kind(component, kind)
        shared = self._share(component_ref, kind, transport)
        try:
            async with shared.stream.subscribe(waiting) as subscription:
                reader = StreamReader(shared.stream, subscription, convert, self._clock, shared.follow)
                shared.readers.append(reader)
                try:
                    shared.follow()
                    await _established(shared.stream, timeout)
                    yield reader
                finally:
                    shared.readers.remove(reader)
                    if shared.readers:
                        shared.follow()
        finally:
            await self._release(shared)

    def _share(self, component_ref: str, kind: MediaKind, transport: Mapping[str, Any]) -> _Shared:
        streams = self._require_open()
        key = component_ref, kind, json.dumps(dict(transport))
        shared = self._shared.get(key)
        if shared is None:
            shared = self._shared[key] = _Shared(
                ReceivedStream(component_ref, kind, streams, self._clock, transport), key
            )
            streams.add(shared.stream)
        shared.users += 1
        return shared

    async def _release(self, shared: _Shared) -> None:
        shared.users -= 1
        if shared.users == 0:
            del self._shared[shared.key]
            if self._streams is not None:
                await self._streams.remove(shared.stream)

    def _require_open(self) -> Streams:
        if self._streams is None:
            raise RuntimeError("use a Media inside its block: async with Media(client) as media")
        return self._streams

    async def _require_kind(self, component: str | ComponentProxy, kind: MediaKind) -> str:
        """Return the reference of a component, unless its type has streams of the other kind alone."""
        self._require_open()
        component_ref = component if isinstance(component, str) else component.component_ref
        if any(key[:2] == (component_ref, kind) for key in self._shared):
            return component_ref
        urn = (await self._client.component(component_ref).profile()).component_type
        for other, proxy in STREAMING_TYPES.items():
            if other != kind and proxy.component_type is not None and urn == proxy.component_type.urn:
                raise ValueError(f"{component_ref} has {other}, not {kind}: use media.{_METHODS[other]}")
        return component_ref


async def _opened(carrier: CarrierStream, timeout: float) -> None:
    try:
        async with asyncio.timeout(timeout):
            await carrier.news.until(lambda: carrier.channel)
    except TimeoutError:
        told = carrier.problem or "its data channels are not open"
        raise TimeoutError(f"there is no way to {carrier.component_ref} within {timeout:g} s: {told}") from None


async def _established(stream: ClientStream, timeout: float) -> None:
    try:
        async with asyncio.timeout(timeout):
            await stream.established()
    except TimeoutError:
        raise TimeoutError(f"the stream of {stream.component_ref} is not connected within {timeout:g} s") from None


def _as_it_is(picture: Any) -> Any:
    return picture


def _said(status: StreamStatus | None) -> str:
    return "unknown, without the gateway" if status is None else status.value


def _require_format(pixel_format: str) -> None:
    """Raise `ValueError` where this is no pixel format."""
    if pixel_format not in ("i420", "rgb24", "bgr24"):
        raise ValueError(f"{pixel_format!r} is not a format of pictures: use i420, rgb24 or bgr24")


def _is_new(picture: DecodedPicture, now: float, clock_until: float) -> bool:
    """Tell whether a picture is new enough for a snapshot; until some time only one of a known age is."""
    is_of_known_age = picture.reported_at is not None or now >= clock_until
    return is_of_known_age and now - picture.captured_at <= SNAPSHOT_AGE
