"""The output of a pipeline: what it says is spoken by a body, and what follows it there is what was heard."""

import asyncio
import sys
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from openrois_media.client.stream import News
from pipecat.frames.frames import (
    BotSpeakingFrame,
    BotStartedSpeakingFrame,
    BotStoppedSpeakingFrame,
    CancelFrame,
    EndFrame,
    Frame,
    InterruptionFrame,
    InterruptionWorkerFrame,
    OutputAudioRawFrame,
    StartFrame,
    SystemFrame,
)
from pipecat.processors.frame_processor import FrameDirection
from pipecat.transports.base_output import BaseOutputTransport
from pipecat.transports.base_transport import TransportParams
from pipecat.utils.utils import obj_id

from openrois_agents.voice.speech_writer import Mark, SpeechWriter

__all__ = ["BodyOutputTransport"]

_MOST_BEHIND: Final = 1_000
"""Frames that wait for the sound before them to be heard."""
_LAST_WORDS: Final = 10.0
"""Seconds within which a body ends what it was told last, before it is silenced."""


@dataclass(frozen=True, slots=True)
class _Behind:
    """A frame that is pushed when the sound before it was heard."""

    mark: Mark
    frame: Frame
    direction: FrameDirection


class BodyOutputTransport(BaseOutputTransport):
    """Speaks through a body; Pipecat resamples to its rate.

    Sound goes ahead to the body, within the bound of its writer. Frames that follow it in order, the sound itself
    among them, are pushed when it was heard, and not at all if it never was. `BotStartedSpeakingFrame` comes when
    viewers hear the first sound, `BotStoppedSpeakingFrame` when the last one was heard; of speech of which nothing was
    heard neither comes. Frames with a time of their own keep it.

    What the body breaks off is an error that the pipeline goes on after, and an interruption.

    Args:
        writer: open for as long as this is used, and used by nothing else.
        params: of the transport.
    """

    def __init__(self, writer: SpeechWriter, params: TransportParams) -> None:
        super().__init__(params)
        self._writer = writer
        self._mark: Mark | None = None
        """The end of the sound that was taken."""
        self._behind: deque[_Behind] = deque()
        self._told: set[FrameDirection] = set()
        """Where a `BotStartedSpeakingFrame` was pushed, and no end of it."""
        self._is_speech = False
        """Whether the sound that is taken is speech, which has an end that is told."""
        self._earliest = 0
        """Number that no frame has which was there at the last interruption; Pipecat counts them."""
        self._changes = News()
        self._pushing: asyncio.Task[None] | None = None
        self._unlisten: Callable[[], None] = lambda: None

    async def start(self, frame: StartFrame) -> None:
        """Begin to speak."""
        await super().start(frame)
        if self._pushing is None:
            self._pushing = self.create_task(self._push_what_was_heard())
            self._unlisten = self._writer.broken_off.add(self._handle_break)
        await self.set_transport_ready(frame)

    async def stop(self, frame: EndFrame) -> None:
        """Speak to the end."""
        await super().stop(frame)
        self._writer.end_utterance()
        with suppress(TimeoutError):
            async with asyncio.timeout(_LAST_WORDS):
                await self._changes.until(lambda: not self._behind)
        self._writer.clear()

    async def cancel(self, frame: CancelFrame) -> None:
        """Fall silent at once."""
        self._writer.clear()
        await super().cancel(frame)

    async def cleanup(self) -> None:
        """Fall silent, also where the pipeline has failed."""
        self._unlisten()
        self._writer.clear()
        if self._pushing is not None:
            pushing, self._pushing = self._pushing, None
            await self.cancel_task(pushing)
        await super().cleanup()

    async def process_frame(self, frame: Frame, direction: FrameDirection) -> None:
        """Fall silent at an interruption; the rest is Pipecat's."""
        await super().process_frame(frame, direction)
        if isinstance(frame, InterruptionFrame):
            # Pipecat has dropped what waits there, but for a frame that it was about to write.
            self._earliest = obj_id()
            if all(each.frame.interruptible for each in self._behind if isinstance(each.frame, OutputAudioRawFrame)):
                self._writer.clear()

    async def write_audio_frame(self, frame: OutputAudioRawFrame) -> bool:
        """Speak a frame, when there is room for it; it is pushed when it was heard.

        Raises:
            ValueError: it has several channels.
        """
        if frame.num_channels != 1:
            raise ValueError(f"sound of {frame.num_channels} channels is not spoken: mix it down to one first")
        if frame.interruptible and frame.id < self._earliest:
            return False
        self._mark = self._writer.mark().after(frame.num_frames / frame.sample_rate)
        self._wait(self._mark, frame)
        await self._writer.write(frame.audio)
        return False

    async def write_transport_frame(self, frame: Frame) -> None:
        """Wait while too many frames wait for the sound before them."""
        await self._changes.until(lambda: len(self._behind) < _MOST_BEHIND)

    async def push_frame(self, frame: Frame, direction: FrameDirection = FrameDirection.DOWNSTREAM) -> None:
        """Push a frame, or let it wait for the sound before it."""
        if isinstance(frame, BotStartedSpeakingFrame):
            self._is_speech = True
            self._mark = self._writer.mark()
        elif isinstance(frame, BotStoppedSpeakingFrame):
            self._is_speech = False
            self._writer.end_utterance()
        elif not (isinstance(frame, BotSpeakingFrame) or (self._behind and _is_in_order(frame, direction))):
            await super().push_frame(frame, direction)
            return
        if self._mark is not None:
            self._wait(self._mark, frame, direction)

    def _wait(self, mark: Mark, frame: Frame, direction: FrameDirection = FrameDirection.DOWNSTREAM) -> None:
        self._behind.append(_Behind(mark, frame, direction))
        self._changes.notify()

    async def _push_what_was_heard(self) -> None:
        while True:
            await self._changes.until(lambda: self._behind)
            first = self._behind[0]
            if await self._is_due(first):
                await super().push_frame(first.frame, first.direction)
            self._behind.popleft()
            self._changes.notify()
            if not self._behind and not self._is_speech:
                # Sound that is no speech has no end that is told.
                self._writer.end_utterance()

    async def _is_due(self, behind: _Behind) -> bool:
        """Wait until the sound before a frame was heard, or is over; return whether the frame is pushed."""
        if isinstance(behind.frame, BotStoppedSpeakingFrame):
            await self._writer.until_ended(behind.mark)
            was_told = behind.direction in self._told
            self._told.discard(behind.direction)
            return was_told
        was_heard = await self._writer.until_heard(behind.mark)
        if isinstance(behind.frame, BotStartedSpeakingFrame):
            if was_heard:
                self._told.add(behind.direction)
            return was_heard
        if was_heard or isinstance(behind.frame, OutputAudioRawFrame | BotSpeakingFrame):
            return was_heard
        # What came after the interruption follows what is not heard any more.
        return not behind.frame.interruptible or behind.frame.id >= self._earliest

    def _handle_break(self, reason: str) -> None:
        # All that comes before the interruption is of what was broken off.
        self._earliest = sys.maxsize
        self.create_task(self._tell_break(reason))

    async def _tell_break(self, reason: str) -> None:
        await self.push_error(f"the body broke off what it said: {reason}")
        # It comes back as an interruption of the whole pipeline.
        await self.push_frame(InterruptionWorkerFrame(), FrameDirection.UPSTREAM)


def _is_in_order(frame: Frame, direction: FrameDirection) -> bool:
    """Tell whether a frame is in one order with the sound: it goes the same way, and has no time of its own."""
    return direction is FrameDirection.DOWNSTREAM and not isinstance(frame, SystemFrame | EndFrame) and not frame.pts
