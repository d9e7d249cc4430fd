"""Feed of one viewer with the frames of a shared source; it changes rendition at a key frame."""

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
"""Seconds after which a source that ended or failed is opened again; with its start, viewers wait less than 1 s."""

RETRY = 1.0
"""Seconds between further tries, while no frame comes."""

STILL_INTERVAL = 1.5
"""Seconds between two pictures for a viewer whose path carries no more. After 2 s our SDK wants another path."""

STILL_LEAST = 0.9
"""Seconds after which a key frame made for others is sent as the next of these pictures: one is requested
`keyframes.STILL_SPACING` later."""

_log = logging.getLogger(__name__)


class Playing(Protocol):
    """Rendition that is being played."""

    async def get(self) -> object:
        """Raise when the source or the encoder has ended or failed; never return."""
        ...


class SharedRendition(Protocol):
    """Encoding of a source, which runs while a viewer plays it."""

    @property
    def rung(self) -> Rung | None:
        """Size, pace and bounds of the bit rate; None if it is the only rendition."""
        ...

    def play(
        self, viewer: Hashable, on_frame: Callable[[EncodedFrame], None], bitrate: float | None = None
    ) -> AbstractAsyncContextManager[Playing]:
        """Call `on_frame` with each frame while the context lasts; a key frame is requested at the start."""
        ...

    def prepare(self) -> AbstractAsyncContextManager[None]:
        """Run source and encoder while the context lasts, for a viewer without a media path yet."""
        ...

    def wanted(self) -> AbstractContextManager[None]:
        """Count it as played while the context lasts, also between two tries."""
        ...

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Request a key frame, within the budget of the cause."""
        ...

    def demand(self, viewer: Hashable, bitrate: float) -> None:
        """Set the demand of `viewer` to `bitrate` (bit/s)."""
        ...

    def least(self, viewer: Hashable) -> float:
        """Return the least demand (bit/s) with which `viewer` can play it."""
        ...


class MediaPublisher(Protocol):
    """Source that is published in several encodings."""

    def renditions(self, mime_type: str, fps: float | None = None) -> Sequence[SharedRendition]:
        """Return its encodings of that media type, the best first, with at most `fps` pictures a second.

        Raises:
            NoEncoder: none runs, and all encoders are in use.
        """
        ...

    def has_room(self, mime_type: str) -> bool:
        """Tell whether a viewer can be sent that media type now."""
        ...

    def can_encode(self, mime_type: str) -> bool:
        """Tell whether encoders of that media type work: false while they fail again and again."""
        ...


class _Part:
    """Rendition that is played, and counts as wanted until the part is left."""

    __slots__ = ("_wanting", "chain", "rendition", "task")

    def __init__(self, rendition: SharedRendition, kind: str) -> None:
        self.rendition = rendition
        self.chain = ReferenceChain(kind)
        self.task: Task[None] | None = None
        self._wanting = ExitStack()
        self._wanting.enter_context(rendition.wanted())

    def leave(self) -> None:
        """Stop playing it."""
        self._wanting.close()
        if self.task is not None:
            self.task.cancel()


class RenditionFeed:
    """Feed of one viewer: frames of one rendition at a time, in growing times, and only decodable ones.

    A change of rendition takes effect at the first key frame of the new one; until then the present one goes on.

    Args:
        kind: "video" or "audio".
        send: sends a frame, at once.
        counters: count lost frames.
        tasks: run the players of renditions.
        clock: times the tries.
    """

    def __init__(
        self, kind: str, send: Callable[[EncodedFrame], None], counters: Counters, tasks: OwnedTasks, clock: MediaClock
    ) -> None:
        self.stills = False
        """Whether key frames alone are sent: one is requested after each `STILL_INTERVAL`, two are never closer than
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
        """The rendition whose frames are sent; None before the first one."""
        return None if self._present is None else self._present.rendition

    def play(self, rendition: SharedRendition, bitrate: float | None = None) -> None:
        """Play `rendition`, from its next key frame on, with a demand of `bitrate` (bit/s)."""
        if self._present is not None and rendition is self._present.rendition:
            self._leave(self._next)
            self._next = None
        elif self._next is None or rendition is not self._next.rendition:
            self._leave(self._next)
            self._next = self._join(rendition, bitrate)
        if bitrate is not None:
            rendition.demand(self, bitrate)

    def repair(self) -> None:
        """Request a key frame for the viewer. Single pictures are key frames, and the next is not brought forward."""
        if self._present is None:
            return
        if self.stills:
            # Should single pictures end before the next one, predicted pictures are of no use.
            self._present.chain = ReferenceChain(self._kind)
        else:
            self._present.rendition.request_key_frame(KeyFrameCause.REPAIR)

    def close(self) -> None:
        """Stop playing. The renditions are left at once, so that their encoders can stop."""
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

        def play_frame(frame: EncodedFrame) -> None:
            nonlocal failing
            failing = False
            self._play_frame(part, frame)

        while True:
            part.chain, pause = ReferenceChain(self._kind), RETRY
            try:
                async with part.rendition.play(self, play_frame, bitrate) as playing:
                    await playing.get()
            except Exception as error:
                pause = RETRY if failing else FIRST_RETRY
                if not failing:
                    text = "a %s source has failed and is opened again every %.0f s: %r"
                    _log.warning(text, self._kind, RETRY, error.__cause__ or error)
                failing = True
            await self._clock.sleep_until(self._clock.now() + pause)

    def _play_frame(self, part: _Part, frame: EncodedFrame) -> None:
        if part is self._next and frame.keyframe:
            self._leave(self._present)
            self._present, self._next = part, None
        if part is not self._present:
            return
        if self.stills and self._kind == "video":
            self._play_still(part, frame)
        elif part.chain.admits(frame):
            self._send_frame(frame)
        else:
            self._counters.frames_dropped += 1
            if part.chain.should_ask(frame):
                part.rendition.request_key_frame(KeyFrameCause.REPAIR)

    def _play_still(self, part: _Part, frame: EncodedFrame) -> None:
        since = frame.captured_at - self._key_at
        if frame.keyframe and since >= STILL_LEAST:
            part.chain.admits(frame)
            self._send_frame(frame)
            return
        self._counters.frames_dropped += 1
        if since >= STILL_INTERVAL:
            part.rendition.request_key_frame(KeyFrameCause.STILL)

    def _send_frame(self, frame: EncodedFrame) -> None:
        if frame.keyframe:
            self._key_at = frame.captured_at
        # The new rendition may be behind the previous one; no two frames have the same time.
        if frame.pts <= self._last_pts:
            frame = replace(frame, pts=self._last_pts + 1)
        self._last_pts = frame.pts
        self._send(frame)
