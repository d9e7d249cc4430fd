"""Brings the frames of a shared source to one viewer: of one rendition, and from its first key frame on of another."""

import logging
from collections.abc import Callable, Hashable, Sequence
from contextlib import AbstractAsyncContextManager, AbstractContextManager, ExitStack
from dataclasses import replace
from typing import Protocol

from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.reference_chain import ReferenceChain
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks, Task

FIRST_RETRY = 0.5
"""Seconds after which a source that ended or failed is opened again: with its start, viewers wait less than one."""

RETRY = 1.0
"""Seconds between further tries, while no frame comes."""

STILL_INTERVAL = 1.5
"""Seconds between two pictures for a viewer whose path carries nothing else. After 2 s our SDK wants another path."""

STILL_LEAST = 0.9
"""Seconds after which a key frame that is there anyway is taken as the next of these pictures: one is asked for
`keyframes.STILL_SPACING` later."""

_log = logging.getLogger(__name__)


class Playing(Protocol):
    """A rendition that is played."""

    async def get(self) -> object:
        """Raise when the source or the encoder has ended or failed; return never."""
        ...


class SharedRendition(Protocol):
    """One encoding of a source, which runs while somebody plays it."""

    @property
    def rung(self) -> Rung | None:
        """Its size, pace and bounds of bit rate; None if it has no others beside it."""
        ...

    def play(
        self, viewer: Hashable, take: Callable[[EncodedFrame], None], bitrate: float | None = None
    ) -> AbstractAsyncContextManager[Playing]:
        """Have `take` called with each frame while the context lasts; a key frame is asked for, to start with."""
        ...

    def prepare(self) -> AbstractAsyncContextManager[None]:
        """Have source and encoder run while the context lasts, for a viewer that cannot be sent anything yet."""
        ...

    def wanted(self) -> AbstractContextManager[None]:
        """Have it count as played while the context lasts, also between two tries to play what fails."""
        ...

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Have the next frame encoded as a key frame, within the budget of the cause."""
        ...

    def demand(self, viewer: Hashable, bitrate: float) -> None:
        """`viewer`, who plays it, can take `bitrate` (bit/s) from now on."""
        ...

    def least(self, viewer: Hashable) -> float:
        """Bit/s that `viewer` must be able to take to play it."""
        ...


class MediaPublisher(Protocol):
    """A source that can be had in several encodings."""

    def renditions(self, mime_type: str, fps: float | None = None) -> Sequence[SharedRendition]:
        """Its encodings of that media type, the best first, with at most so many pictures a second.

        Raises:
            NoEncoder: there is none, and all encoders are in use.
        """
        ...

    def has_room(self, mime_type: str) -> bool:
        """Whether a viewer can be played something in that media type now."""
        ...

    def can_encode(self, mime_type: str) -> bool:
        """Whether its encoders of that media type work, as far as is known: not while they fail again and again."""
        ...


class _Part:
    """A rendition that is played, and wanted until the part is left: what others may have follows from it."""

    __slots__ = ("_wanting", "chain", "rendition", "task")

    def __init__(self, rendition: SharedRendition, kind: str) -> None:
        self.rendition = rendition
        self.chain = ReferenceChain(kind)
        self.task: Task[None] | None = None
        self._wanting = ExitStack()
        self._wanting.enter_context(rendition.wanted())

    def leave(self) -> None:
        """Play it no more."""
        self._wanting.close()
        if self.task is not None:
            self.task.cancel()


class RenditionFeed:
    """Gives one viewer the frames of one rendition at a time, in growing times, and never one it could not decode.

    When another rendition is to be played, the present one goes on until the first key frame of the other is there.

    Args:
        kind: "video" or "audio".
        send: takes a frame, at once.
        counters: where lost frames are counted.
        tasks: what the renditions are played in.
        clock: for the time between two tries.
    """

    def __init__(
        self, kind: str, send: Callable[[EncodedFrame], None], counters: Counters, tasks: OwnedTasks, clock: MediaClock
    ) -> None:
        self.stills = False
        """Whether key frames alone are sent: one is asked for after each `STILL_INTERVAL`, two are never closer than
        `STILL_LEAST`."""
        self._kind = kind
        self._send = send
        self._counters = counters
        self._tasks = tasks
        self._clock = clock
        self._present: _Part | None = None
        self._next: _Part | None = None
        self._last_pts = -1
        self._key_at = float("-inf")

    @property
    def rendition(self) -> SharedRendition | None:
        """The one whose frames are sent; None before the first one."""
        return None if self._present is None else self._present.rendition

    def play(self, rendition: SharedRendition, bitrate: float | None = None) -> None:
        """Play `rendition`, from its next key frame on. The viewer can take `bitrate` (bit/s)."""
        if self._present is not None and rendition is self._present.rendition:
            self._leave(self._next)
            self._next = None
        elif self._next is None or rendition is not self._next.rendition:
            self._leave(self._next)
            self._next = self._join(rendition, bitrate)
        if bitrate is not None:
            rendition.demand(self, bitrate)

    def repair(self) -> None:
        """The viewer needs a key frame. Of single pictures the next is one, and would come later if asked for early."""
        if self._present is None:
            return
        if self.stills:
            # Should they end before that one, what is predicted is of no use.
            self._present.chain = ReferenceChain(self._kind)
        else:
            self._present.rendition.request_key_frame(KeyFrameCause.REPAIR)

    def close(self) -> None:
        """Play nothing. The renditions are left at once, so that their encoders can rest."""
        self._leave(self._present)
        self._leave(self._next)
        self._present = self._next = None

    def _join(self, rendition: SharedRendition, bitrate: float | None) -> _Part:
        part = _Part(rendition, self._kind)
        part.task = self._tasks.start(self._keep_playing(part, bitrate), f"play {self._kind}")
        return part

    def _leave(self, part: _Part | None) -> None:
        if part is not None:
            part.leave()

    async def _keep_playing(self, part: _Part, bitrate: float | None) -> None:
        failing = False

        def take(frame: EncodedFrame) -> None:
            nonlocal failing
            failing = False
            self._take(part, frame)

        while True:
            part.chain, pause = ReferenceChain(self._kind), RETRY
            try:
                async with part.rendition.play(self, take, bitrate) as playing:
                    await playing.get()
            except Exception as error:
                pause = RETRY if failing else FIRST_RETRY
                if not failing:
                    told = "a %s source stopped; it is tried again every %.0f s: %r"
                    _log.warning(told, self._kind, RETRY, error.__cause__ or error)
                failing = True
            await self._clock.sleep_until(self._clock.now() + pause)

    def _take(self, part: _Part, frame: EncodedFrame) -> None:
        if part is self._next and frame.keyframe:
            self._leave(self._present)
            self._present, self._next = part, None
        if part is not self._present:
            return
        if self.stills and self._kind == "video":
            self._take_still(part, frame)
        elif part.chain.admits(frame):
            self._give(frame)
        else:
            self._counters.frames_dropped += 1
            if part.chain.should_ask(frame):
                part.rendition.request_key_frame(KeyFrameCause.REPAIR)

    def _take_still(self, part: _Part, frame: EncodedFrame) -> None:
        since = frame.captured_at - self._key_at
        if frame.keyframe and since >= STILL_LEAST:
            part.chain.admits(frame)
            self._give(frame)
            return
        self._counters.frames_dropped += 1
        if since >= STILL_INTERVAL:
            part.rendition.request_key_frame(KeyFrameCause.STILL)

    def _give(self, frame: EncodedFrame) -> None:
        if frame.keyframe:
            self._key_at = frame.captured_at
        # Another rendition may be behind the one that was played before; no two frames have the same time.
        if frame.pts <= self._last_pts:
            frame = replace(frame, pts=self._last_pts + 1)
        self._last_pts = frame.pts
        self._send(frame)
