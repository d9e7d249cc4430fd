"""One stream of an application, kept in the wanted state: verb by verb, with retries."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final, Protocol

from openrois_signaling.messages import Direction, MediaKind
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.fanout import Subscription
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.viewing.speech_channel import SpeechChannel
from openrois_streaming.viewing.switched_source import SwitchedSource

from openrois.client import ConnectionLost, RoISError, RpcError, Unsupported
from openrois.types.codes import StreamStatus
from openrois_media.client.peer import Attachment, Place
from openrois_media.client.playout_reports import PlayoutReports
from openrois_media.client.stream_state import Desire, Failure, Problem, StreamState, Verb

__all__ = [
    "AUDIO_BLOCKS",
    "NOTHING_MORE",
    "CarrierStream",
    "ClientStream",
    "News",
    "ReceivedStream",
    "SentStream",
    "StreamOperations",
]

AUDIO_BLOCKS: Final = 50
"""Blocks of sound, 20 ms each, that wait for a slow reader; the oldest makes room for the newest."""

NOTHING_MORE: Final[Mapping[str, Any]] = MappingProxyType({})
"""Members of `transport_parameters` of a stream that is received, or sent, as any other."""

_log = logging.getLogger(__name__)


class News:
    """Waiters of conditions, woken by each `notify`."""

    def __init__(self) -> None:
        self._event = asyncio.Event()

    def notify(self) -> None:
        """Wake all waiters, which look at their conditions again."""
        self._event.set()
        self._event = asyncio.Event()

    async def until(self, so: Callable[[], object]) -> None:
        """Wait until `so()` is true."""
        while not so():
            await self._event.wait()


class StreamOperations(Protocol):
    """What a stream needs of all streams."""

    def ready(self) -> bool:
        """Tell whether the gateway can be asked now."""
        ...

    async def connect(self, stream: "ClientStream") -> str:
        """Connect a stream; returns its id."""
        ...

    async def perform(self, verb: Verb, stream_id: str) -> None:
        """Carry out a verb on a connected stream."""
        ...

    def relocate(self, stream: "ClientStream") -> None:
        """Look again where a stream is carried: it has another id, or none."""
        ...


class ClientStream:
    """A stream. What was lost is connected again; a suspended stream comes back suspended.

    Args:
        component_ref: its component.
        kind: "video" or "audio".
        direction: seen from the application.
        operations: what it needs of all streams.
        clock: monotonic times.
        transport: members of its `transport_parameters` beside the direction.
    """

    def __init__(
        self,
        component_ref: str,
        kind: MediaKind,
        direction: Direction,
        operations: StreamOperations,
        clock: MediaClock,
        transport: Mapping[str, Any],
    ) -> None:
        self.transport = transport
        self.known_transport: Mapping[str, Any] | None = None
        """What of it the engine knows: that of its last connection, or what was stated since."""
        self.component_ref = component_ref
        self.kind = kind
        self.direction = direction
        self.state = StreamState()
        self.place = Place(self._attached, self._left)
        self.news = News()
        self._operations = operations
        self._clock = clock
        self._wake = asyncio.Event()
        self._busy = False
        self._fault: tuple[str, int] | None = None
        """What its component has reported, and how many frames there were then."""

    @property
    def problem(self) -> str:
        """What keeps the stream from running, in a sentence; empty for nothing."""
        if self.state.problem is not None:
            return self.state.problem.detail
        words, frames = self._fault or ("", 0)
        return words if frames == self._frames else ""

    @property
    def is_unknown(self) -> bool:
        """Whether the engine has said, when it was asked to connect the stream again, that there is no such stream."""
        problem = self.state.problem
        return self.state.stream_id is None and problem is not None and isinstance(problem.error, Unsupported)

    def note_fault(self, words: str) -> None:
        """Note what its component has reported; the next frame says that it is over."""
        self._fault = (words, self._frames)
        self.news.notify()

    @property
    def _frames(self) -> int:
        newest = self.place.newest
        return 0 if newest is None else newest.frames

    @property
    def expects_media(self) -> bool:
        """Whether media should be arriving."""
        return self.state.expects_media(flowed=self.place.flowed)

    async def run(self) -> None:
        """Bring the stream into the wanted state, again and again, until this is cancelled."""
        while True:
            self._wake.clear()
            verb = self.state.due(self._clock.now()) if self._operations.ready() else None
            if verb is not None:
                self._busy = True
                try:
                    await self._perform(verb)
                finally:
                    self._busy = False
                self.news.notify()
            else:
                await self._rest()

    def want(self, desire: Desire) -> None:
        """Change the desired state."""
        self.state.want(desire)
        self._changed()

    async def settled(self) -> None:
        """Wait until the desired state is reached, or has to wait."""
        await self.news.until(lambda: not self._busy and not self._is_due)

    async def established(self) -> None:
        """Wait until the stream is connected, or was refused.

        Raises:
            RoISError, RpcError: it was refused.
        """
        await self.news.until(lambda: self.state.stream_id is not None or self.state.problem is not None)
        if self.state.stream_id is None and self.state.problem is not None and self.state.problem.error is not None:
            raise self.state.problem.error

    def retry_now(self) -> None:
        """Try at once what has failed."""
        self.state.retry_now()
        self._wake.set()

    def reported(self, status: StreamStatus) -> None:
        """Apply a status that the engine has reported."""
        if status is StreamStatus.STREAMING_NOT_CONNECTED:
            self.lost(status)
        else:
            self.state.reported(status, self._clock.now())
            self._changed()

    def lost(self, status: StreamStatus | None) -> None:
        """Note that the stream is not connected any more; None for an unknown status."""
        if self.state.lost(status, self._clock.now()):
            self.place.connection_ended()
        self._changed()

    def fail(self, problem: Problem | None) -> None:
        """Note what keeps the stream from running."""
        self.state.problem = problem
        self._changed()

    def sample(self) -> None:
        """Look at the counts of the sections; to be called about once a second."""
        newest, following = self.place.newest, self.place.next
        if newest is not None and newest.frames > 0:
            self.state.flowed()
            if self.state.problem is not None and self.state.problem.error is None:
                self.fail(None)
        if following is not None and not self.expects_media and following.peer.is_connected:
            self.place.promote()

    def _attached(self, attachment: Attachment) -> None:
        """Note that a section carries the stream."""

    def _left(self, attachment: Attachment) -> None:
        """Note that a section does not carry the stream any more."""

    @property
    def _is_due(self) -> bool:
        return self._operations.ready() and self.state.due(self._clock.now()) is not None

    def _changed(self) -> None:
        self._wake.set()
        self.news.notify()

    async def _rest(self) -> None:
        """Wait for a change, or for the next attempt; while the gateway is away, for `retry_now`."""
        waits = self.state.pending is not None and self._operations.ready()
        at = self.state.retry_at if waits else None
        try:
            async with asyncio.timeout(None if at is None else max(at - self._clock.now(), 0.0)):
                await self._wake.wait()
        except TimeoutError:
            # The times of a timer and of the clock may differ by a little.
            if at is not None:
                await self._clock.sleep_until(at)

    async def _perform(self, verb: Verb) -> None:
        try:
            if verb is Verb.CONNECT:
                self.state.connected(await self._operations.connect(self), self._clock.now())
                self._operations.relocate(self)
                return
            stream_id = self.state.stream_id
            assert stream_id is not None, "only a connected stream has such a verb"
            if verb is Verb.DISCONNECT:
                self.state.release()
                self.place.drop()
                self._operations.relocate(self)
            await self._operations.perform(verb, stream_id)
            self.state.performed(verb, stream_id)
        except (RoISError, RpcError, ConnectionLost, TimeoutError) as error:
            self.state.failed(verb, _failure_of(error), Problem(str(error), error), self._clock.now())
            if self.state.stream_id is None:
                self.place.connection_ended()


def _failure_of(error: Exception) -> Failure:
    if isinstance(error, ConnectionLost):
        return Failure.NO_CONNECTION
    return Failure.UNSUPPORTED if isinstance(error, Unsupported) else Failure.REFUSED


class ReceivedStream(ClientStream):
    """A stream that the application receives, shared by its readers: one decoder for all."""

    def __init__(
        self,
        component_ref: str,
        kind: MediaKind,
        operations: StreamOperations,
        clock: MediaClock,
        transport: Mapping[str, Any] = NOTHING_MORE,
    ) -> None:
        super().__init__(component_ref, kind, "recvonly", operations, clock, transport)
        self._source = SwitchedSource[Any](component_ref, self._switched)
        self._reports = PlayoutReports()
        self._is_of_visitor = "visitor_ref" in transport

    def subscribe(self, waiting: int) -> Subscription[Any]:
        """Return a subscription to its frames, which are decoded while there is one; so many wait at most."""
        return self._source.subscribe(waiting)

    def playout_due(self) -> float | None:
        """Return the playout delay to be reported to the engine, in seconds; None for none."""
        current = self.place.current
        if self.kind == "video" or current is None or current.section.receiver is None:
            return None
        delay = current.section.receiver.figures.playout_delay
        return self._reports.due(self.state.stream_id, delay, self._clock.now())

    def lost(self, status: StreamStatus | None) -> None:
        """Note that the stream is not connected any more; None for an unknown status."""
        super().lost(status)
        if self._is_of_visitor and status is StreamStatus.STREAMING_NOT_CONNECTED:
            # The visitor may have withdrawn its consent: what is on its way is not used.
            self.place.drop()
            self._source.drop_waiting()

    def end_frames(self) -> None:
        """End the frames: the stream will not be connected again."""
        self._source.end_input()

    def _attached(self, attachment: Attachment) -> None:
        self._source.add(attachment.source)

    def _left(self, attachment: Attachment) -> None:
        kept = [each.source for each in self.place.attachments() if each is not attachment]
        if attachment.source not in kept:
            self._source.remove(attachment.source)

    def _switched(self, source: MediaSource[Any]) -> None:
        following = self.place.next
        if following is not None and following.source is source:
            self.place.promote()


class CarrierStream(ClientStream):
    """A suspended stream, for the peer connection that it has: over its channels the application speaks by sound."""

    def __init__(self, component_ref: str, kind: MediaKind, operations: StreamOperations, clock: MediaClock) -> None:
        super().__init__(component_ref, kind, "recvonly", operations, clock, {"speech": True})

    @property
    def expects_media(self) -> bool:
        """Whether media should be arriving: none does, it is suspended."""
        return False

    @property
    def channel(self) -> SpeechChannel | None:
        """The newest channels that are open."""
        channels = [each.peer.speech for each in reversed(self.place.attachments())]
        return next((each for each in channels if each.is_open), None)


class SentStream(ClientStream):
    """A stream that the application sends: a source, open while the stream is wanted and the engine takes it.

    Attributes:
        failure: why the source has failed; None if it has not.
        ended: whether the source has ended or failed.
    """

    def __init__(
        self,
        component_ref: str,
        kind: MediaKind,
        source: MediaSource[RawVideo] | MediaSource[RawAudio],
        operations: StreamOperations,
        clock: MediaClock,
        transport: Mapping[str, Any] = NOTHING_MORE,
    ) -> None:
        super().__init__(component_ref, kind, "sendonly", operations, clock, transport)
        self._source: MediaSource[Any] = source
        self.failure: Exception | None = None
        self.ended = False

    @property
    def expects_media(self) -> bool:
        """Whether media should be arriving: none does, it is sent."""
        return False

    async def run_source(self) -> None:
        """Read the source whenever its frames can be sent, until it ends or this is cancelled."""
        try:
            while not self.ended:
                await self.news.until(lambda: self._sends)
                await self._read()
        except Exception as error:  # whatever a source raises
            _log.warning("%s: what is sent to it has failed: %r", self.component_ref, error)
            self.failure = error
        finally:
            self.ended = True
            self.news.notify()

    @property
    def _sends(self) -> bool:
        wanted = self.state.desire is Desire.RUNNING and self.state.status is not StreamStatus.STREAMING_SUSPENDED
        return wanted and any(each.peer.is_connected for each in self.place.attachments())

    async def _read(self) -> None:
        async with self._source.open() as frames:
            async for frame in frames:
                if not self._sends:
                    return
                if self.known_transport is not self.transport:
                    # The engine does not know yet what may be done with it now.
                    continue
                for each in self.place.attachments():
                    if each.section.outgoing is not None and each.peer.is_connected:
                        each.section.outgoing.put(frame)
        self.ended = True
