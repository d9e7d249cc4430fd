"""Speech recognition, language model and voice for Pipecat that need no service, and what a pipeline tells."""

import asyncio
from collections.abc import AsyncGenerator, Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openrois_media.client.stream import News
from pipecat.frames.frames import (
    BotStartedSpeakingFrame,
    BotStoppedSpeakingFrame,
    DataFrame,
    Frame,
    LLMContextFrame,
    LLMFullResponseEndFrame,
    LLMFullResponseStartFrame,
    LLMTextFrame,
    OutputAudioRawFrame,
    ProposedUserStartedSpeakingFrame,
    ProposedUserStoppedSpeakingFrame,
    TranscriptionFrame,
    TTSAudioRawFrame,
    UserAudioRawFrame,
)
from pipecat.observers.base_observer import BaseObserver, FramePushed
from pipecat.processors.frame_processor import FrameDirection, FrameProcessor
from pipecat.services.settings import TTSSettings
from pipecat.services.tts_service import TTSService

from tests.support.loopback import PATIENCE
from tests.support.sounds import tone

__all__ = ["Beeps", "Downstream", "Note", "Pitches", "Rules"]

_LOUD = 1_000
_RATE = 16_000
_QUIET = 0.6
"""Seconds without sound that end what is said, and are not what a busy machine lost of it."""
_LONG = 0.1
"""Seconds of sound that are speech."""


class Pitches(FrameProcessor):
    """Recognises tones: each pitch is a word.

    Args:
        words: the word of each pitch.

    Attributes:
        heard: seconds of sound that were loud, by the visitor's reference; silence behind visitors is of none.
        news: told of each frame of sound.
    """

    def __init__(self, words: Mapping[float, str]) -> None:
        super().__init__()
        self.words = words
        self.heard: dict[str, float] = {}
        self.news = News()
        self._said: NDArray[np.int16] = np.zeros(0, np.int16)
        self._quiet = 0.0
        self._speaks = False

    def forget(self) -> None:
        """Forget what was said last, and not answered yet."""
        self._said, self._quiet, self._speaks = np.zeros(0, np.int16), 0.0, False

    async def process_frame(self, frame: Frame, direction: FrameDirection) -> None:
        await super().process_frame(frame, direction)
        if isinstance(frame, UserAudioRawFrame):
            await self._listen(frame)
        await self.push_frame(frame, direction)

    async def _listen(self, frame: UserAudioRawFrame) -> None:
        samples = np.frombuffer(frame.audio, np.int16)
        seconds = len(samples) / frame.sample_rate
        is_loud = np.abs(samples.astype(int)).max(initial=0) > _LOUD
        self.heard[frame.user_id] = self.heard.get(frame.user_id, 0.0) + (seconds if is_loud else 0.0)
        self.news.notify()
        if is_loud:
            self._said, self._quiet = np.concatenate((self._said, samples)), 0.0
            if not self._speaks and len(self._said) >= _RATE * _LONG:
                self._speaks = True
                await self.broadcast_frame(ProposedUserStartedSpeakingFrame)
        elif self._speaks and (quiet := self._quiet + seconds) < _QUIET:
            self._quiet = quiet
        elif self._speaks:
            word = self._word()
            self.forget()
            await self.push_frame(TranscriptionFrame(word, frame.user_id, "2026-01-01T00:00:00Z", finalized=True))
            await self.broadcast_frame(ProposedUserStoppedSpeakingFrame)

    def _word(self) -> str:
        pitch = np.abs(np.fft.rfft(self._said)).argmax() * _RATE / len(self._said)
        return self.words[min(self.words, key=lambda each: abs(each - pitch))]


class Rules(FrameProcessor):
    """Answers by rules.

    Args:
        answers: to what was said last.

    Attributes:
        asked: all that was said.
    """

    def __init__(self, answers: Mapping[str, str]) -> None:
        super().__init__()
        self.answers = answers
        self.asked: list[str] = []

    async def process_frame(self, frame: Frame, direction: FrameDirection) -> None:
        await super().process_frame(frame, direction)
        if not isinstance(frame, LLMContextFrame):
            await self.push_frame(frame, direction)
            return
        asked = [str(each["content"]) for each in frame.context.get_messages() if each["role"] == "user"][-1]
        self.asked.append(asked)
        await self.push_frame(LLMFullResponseStartFrame())
        for word in self.answers[asked].split(" "):
            await self.push_frame(LLMTextFrame(f"{word} "))
        await self.push_frame(LLMFullResponseEndFrame())


class Beeps(TTSService):
    """A voice that beeps for so long as a text is, much faster than it is heard.

    Args:
        per_word: seconds of a word.
    """

    def __init__(self, per_word: float) -> None:
        super().__init__(
            push_start_frame=True,
            push_stop_frames=True,
            sample_rate=_RATE,
            settings=TTSSettings(model=None, voice=None, language=None),
        )
        self.per_word = per_word

    async def run_tts(self, text: str, context_id: str) -> AsyncGenerator[Frame | None, None]:
        sound = tone(len(text.split()) * self.per_word, _RATE)
        yield TTSAudioRawFrame(sound.tobytes(), _RATE, 1, context_id=context_id)


class Note(DataFrame):
    """A frame of an application, which follows sound in order."""


class Downstream(BaseObserver):
    """Notes what an output pushes on; what stands behind it may lose a part of that at an interruption.

    Args:
        output: the processor.

    Attributes:
        frames: all of them.
        steps: `started` and `stopped`, as they come.
        seconds: of sound that came.
    """

    def __init__(self, output: FrameProcessor) -> None:
        super().__init__()
        self.frames: list[Frame] = []
        self.steps: list[str] = []
        self.seconds = 0.0
        self._output = output
        self._news = News()

    async def on_push_frame(self, data: FramePushed) -> None:
        if data.source is not self._output or data.direction is not FrameDirection.DOWNSTREAM:
            return
        self.frames.append(data.frame)
        if isinstance(data.frame, BotStartedSpeakingFrame):
            self.steps.append("started")
        elif isinstance(data.frame, BotStoppedSpeakingFrame):
            self.steps.append("stopped")
        elif isinstance(data.frame, OutputAudioRawFrame):
            self.seconds += data.frame.num_frames / data.frame.sample_rate
        self._news.notify()

    def notify(self, *_: Any) -> None:
        """Look at conditions again."""
        self._news.notify()

    async def until(self, so: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE):
            await self._news.until(so)
