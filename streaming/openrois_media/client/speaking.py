"""Speech as sound of an application: pushed at the pace at which it is heard, with its progress."""

import asyncio
import json
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.input.credit import CreditSender
from openrois_streaming.input.speech import (
    FRAME_HEAD,
    SPEECH_MESSAGE_LIMIT,
    Begin,
    Clear,
    End,
    Finished,
    Frame,
    Granted,
    Refused,
    SpeechFormat,
    SpeechTold,
    Started,
    Starved,
    TimedWord,
    Words,
    pack_frame,
)
from openrois_streaming.publish.audio_encoder import SAMPLES_PER_PACKET, OpusEncoder
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio
from openrois_streaming.viewing.speech_channel import SpeechChannel

from openrois.client import Aborted
from openrois_media.client.stream import News

__all__ = ["LOST", "Speaking", "SpeechSender", "Spoken", "SpokenWord"]

SPOKEN_EVENTS: Final = 256
"""Steps of speech that wait for a slow reader; the oldest makes room for the newest."""
_FRAME_SAMPLES: Final = (SPEECH_MESSAGE_LIMIT - FRAME_HEAD.size) // 2
_OPUS_BITRATE: Final = 48_000
_CLEARED: Final = "the speech was cleared before this was spoken"
LOST: Final = "the connection over which it was spoken was lost"

Samples = NDArray[np.int16] | NDArray[np.float32] | NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Spoken:
    """What became of a speech.

    Attributes:
        seconds: of it that were heard.
        reason: why it was interrupted; empty if it was heard to its end.
    """

    seconds: float
    reason: str = ""

    @property
    def interrupted(self) -> bool:
        """Whether it was not heard to its end."""
        return bool(self.reason)


@dataclass(frozen=True, slots=True)
class SpokenWord:
    """A word of a speech, and the second of the speech at which it begins."""

    text: str
    start: float


class SpeechSender:
    """One speech, from its first frame to its end. What the body tells of it goes to `handle`.

    Args:
        begin: how it begins.
        channel: over which it goes.
    """

    def __init__(self, begin: Begin, channel: SpeechChannel) -> None:
        self.number = begin.utterance
        self.channel = channel
        self.credit = CreditSender(begin.rate)
        self.news = News()
        self.result: Spoken | None = None
        """What became of it; None while it is spoken."""
        self._rate = begin.rate
        self._sequence = 0
        channel.speak(_text(begin.to_json()))

    @property
    def played(self) -> float:
        """Seconds of it that have been played, as far as the body has told."""
        return self.credit.played / self._rate if self.result is None else self.result.seconds

    async def push(self, sound: bytes, samples: int) -> None:
        """Send a frame as soon as there is credit for its samples.

        Raises:
            Aborted: the speech was interrupted; the text says why.
        """
        await self.news.until(lambda: self.result is not None or self.credit.room >= samples)
        if self.result is not None:
            raise Aborted(self.result.reason)
        self.credit.send(samples)
        self.channel.speak(pack_frame(Frame(self.number, self._sequence, sound)))
        self._sequence += 1

    def send(self, message: Words | End) -> None:
        """Send a message in order with the sound."""
        if self.result is None:
            self.channel.speak(_text(message.to_json()))

    def clear(self) -> None:
        """Silence it at once."""
        if self.result is None:
            self.channel.overtake(_text(Clear(self.number).to_json()))

    async def over(self) -> Spoken:
        """Wait until it is over."""
        await self.news.until(lambda: self.result is not None)
        assert self.result is not None, "that is what was waited for"
        return self.result

    def handle(self, told: SpeechTold) -> None:
        """Handle what the body tells of it."""
        match told:
            case Granted():
                self.credit.granted(told.samples, told.played)
            case Starved():
                # Less than a step of credit may have been played since the last one.
                self.credit.granted(0, round(told.position * self._rate / 1000))
            case Finished() | Refused():
                seconds = told.position / 1000 if isinstance(told, Finished) else 0.0
                self.result = self.result or Spoken(seconds, told.reason)
        self.news.notify()


@dataclass(slots=True)
class _Pushes:
    """What is pushed up to the next `finish`.

    Attributes:
        interrupted: why that was interrupted; what of it waits to be sent is dropped then.
    """

    interrupted: str = ""


class Speaking:
    """Sound that an application speaks through a body, inside the block of `Media.speech`.

    A speech begins with the first `push` and ends with `finish` or `clear`. The next `push` begins another one, which
    is heard behind it.

    Attributes:
        component_ref: the component that speaks.
        rate: samples a second of what is pushed.
    """

    def __init__(
        self,
        component_ref: str,
        rate: int,
        format: SpeechFormat,
        begin: Callable[[Begin, "Speaking"], SpeechSender],
        number: Callable[[], int],
    ) -> None:
        """Use `Media.speech`. `begin` begins a speech over an open channel, `number` returns its number."""
        self.component_ref = component_ref
        self.rate = rate
        self._format: SpeechFormat = format
        self._begin = begin
        self._number = number
        self._current: SpeechSender | None = None
        self._latest: SpeechSender | None = None
        self._spoken: list[SpeechSender] = []
        """Speeches that are not over, the present one last."""
        self._packets: _Packets | None = None
        self._turn = asyncio.Lock()
        self._pushes = _Pushes()
        self._clears = 0
        self._steps: deque[SpeechTold] = deque(maxlen=SPOKEN_EVENTS)
        self._news = News()
        self._closed = False

    @property
    def utterance(self) -> int | None:
        """Number of the present speech or, where there is none, of the last one, as `events` has it."""
        return None if self._latest is None else self._latest.number

    @property
    def played(self) -> float:
        """Seconds that have been played of the present speech, as far as the body has told, ten times a second.

        Where there is none, of the last one, which may still be heard.
        """
        return 0.0 if self._latest is None else self._latest.played

    async def until_played(self, seconds: float) -> None:
        """Wait until so much of the present speech, or of the last one, has been played, or it is over."""
        if (sender := self._latest) is not None:
            await sender.news.until(lambda: sender.result is not None or sender.played >= seconds)

    async def push(self, samples: Samples, *, text: str = "") -> None:
        """Speak on; returns when all was sent, which is when less than a second of it waits to be heard.

        Args:
            samples: mono, of shape (n,) or (n, 1): int16, or floats from -1 to 1.
            text: what the speech that begins here says, for captions; passed over in the middle of one.

        Raises:
            Aborted: the speech was interrupted, as by its end of the right to speak; the next push begins another one.
            ConnectionLost: there is no connection to the body now.
            ValueError: it is not such an array.
        """
        sound = _pcm(samples)
        pushes, clears = self._pushes, self._clears
        async with self._turn:
            # It has waited for its turn behind others.
            if why := pushes.interrupted if clears == self._clears else _CLEARED:
                raise Aborted(why)
            sender = self._current or self._begin_speech(text)
            try:
                for part, count in self._parts(sound):
                    await sender.push(part, count)
            except Aborted as aborted:
                pushes.interrupted = str(aborted)
                if self._pushes is pushes:
                    self._pushes = _Pushes()
                self._leave(sender)
                raise

    def add_words(self, words: Iterable[SpokenWord], *, text: str = "") -> None:
        """Say when words of the present speech begin; their sound may be pushed before or after that.

        Args:
            words: in any order.
            text: as in `push`.
        """
        sender = self._current or self._begin_speech(text)
        timed = [TimedWord(word.text, round(word.start * 1000)) for word in words]
        for first in range(0, len(timed), _WORDS_AT_ONCE):
            sender.send(Words(sender.number, tuple(timed[first : first + _WORDS_AT_ONCE])))

    async def finish(self) -> Spoken:
        """End the present speech, and wait until all of it was heard; without one, until the last one is over."""
        self._pushes = _Pushes()
        async with self._turn:
            sender = self._current
            if sender is not None:
                await self._end(sender)
            latest = self._latest
        return Spoken(0.0) if latest is None else await latest.over()

    async def clear(self) -> Spoken:
        """Silence all that was pushed, at once, also what waits to be sent.

        Returns:
            What was heard of the present speech, or of the last one.
        """
        self._clears += 1
        senders = [each for each in self._spoken if each.result is None]
        for sender in senders:
            sender.clear()
            self._leave(sender)
        latest = self._latest
        for sender in senders:
            await sender.over()
        return Spoken(0.0) if latest is None else await latest.over()

    async def finish_all(self) -> None:
        """End the present speech, and wait until all speeches are over."""
        await self.finish()
        for sender in tuple(self._spoken):
            await sender.over()

    async def events(self) -> AsyncIterator[Started | Starved | Finished | Refused]:
        """Yield what becomes of all speeches, until the block ends: `async for step in speech.events()`.

        `Started` when the first sound is heard, `Starved` when it runs dry, `Finished` with the milliseconds heard.
        """
        while True:
            await self._news.until(lambda: self._steps or self._closed)
            if not self._steps:
                return
            step = self._steps.popleft()
            if not isinstance(step, Granted):
                yield step

    def handle(self, sender: SpeechSender, told: SpeechTold) -> None:
        """Handle what the body tells of a speech."""
        sender.handle(told)
        if sender.result is not None and sender in self._spoken:
            self._spoken.remove(sender)
        if not isinstance(told, Granted):
            self._steps.append(told)
            self._news.notify()

    def close(self) -> None:
        """End `events`, and silence what is not over."""
        self._closed = True
        for sender in self._spoken:
            sender.clear()
        self._news.notify()

    def _begin_speech(self, text: str) -> SpeechSender:
        self._packets = _Packets() if self._format == "opus" else None
        sender = self._current = self._latest = self._begin(Begin(self._number(), self._format, self.rate, text), self)
        self._spoken.append(sender)
        return sender

    async def _end(self, sender: SpeechSender) -> None:
        try:
            if self._packets is not None:
                for part, count in self._packets.finish():
                    await sender.push(part, count)
            sender.send(End(sender.number))
        except Aborted:
            pass  # What became of it says why.
        finally:
            self._leave(sender)

    def _leave(self, sender: SpeechSender) -> None:
        if self._current is sender:
            self._current = None

    def _parts(self, sound: NDArray[np.int16]) -> Iterable[tuple[bytes, int]]:
        if self._packets is not None:
            return self._packets.push(sound)
        parts = (sound[first : first + _FRAME_SAMPLES] for first in range(0, len(sound), _FRAME_SAMPLES))
        return ((part.astype("<i2").tobytes(), len(part)) for part in parts)


class _Packets:
    """Sound of one speech as packets of Opus, 20 ms each."""

    def __init__(self) -> None:
        self._encoder = OpusEncoder(bitrate=_OPUS_BITRATE)
        self._samples = 0

    def push(self, sound: NDArray[np.int16]) -> list[tuple[bytes, int]]:
        """Return the packets that are full, each with its number of samples."""
        if not len(sound):
            return []
        block = RawAudio(sound[:, np.newaxis], self._samples / SAMPLE_RATE)
        self._samples += len(sound)
        return [(chunk.data, SAMPLES_PER_PACKET) for chunk in self._encoder.encode(block, key_frame=False)]

    def finish(self) -> list[tuple[bytes, int]]:
        """Return the last packet, filled with silence."""
        missing = -self._samples % SAMPLES_PER_PACKET
        return self.push(np.zeros(missing, np.int16))


_WORDS_AT_ONCE: Final = 20
"""Words of one message, which then has room for the longest ones."""


def _pcm(samples: Any) -> NDArray[np.int16]:
    array = np.asarray(samples)
    if array.ndim == 2 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim != 1:
        raise ValueError(f"samples must have the shape (n,) or (n, 1), not {array.shape}: mix channels down first")
    if array.dtype == np.int16:
        return array
    if array.dtype.kind != "f":
        raise ValueError(f"samples must be int16, or floats from -1 to 1, not {array.dtype}")
    return np.asarray(np.rint(np.clip(array, -1, 1) * 32_767), np.int16)


def _text(members: dict[str, Any]) -> str:
    return json.dumps(members, ensure_ascii=False)
