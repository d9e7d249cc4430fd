"""Utterances of an agent: written as fast as they are made, spoken by a body one after the other, silenced at once."""

import asyncio
import logging
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from openrois_media.client.speaking import Speaking, Spoken
from openrois_media.client.stream import News
from openrois_streaming.input.speech import Finished, Refused, Started, Starved

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.client import Aborted, ConnectionLost

__all__ = ["MAX_WRITTEN", "Mark", "SpeechWriter"]

_log = logging.getLogger(__name__)

MAX_WRITTEN: Final = 2.0
"""Seconds of sound that were written and wait to be sent; the body has a second more at most."""
_PIECE: Final = 0.1
"""Seconds of sound that are sent at once."""
_ANSWER: Final = 2.0
"""Seconds within which a body says what was heard of what it was told to silence."""
_SAMPLE: Final = np.dtype("<i2").itemsize
_CLEARED: Final = "the agent was interrupted before this was spoken"
_ROUNDED: Final = 0.002
"""Seconds by which what a body tells may be rounded."""
_INTERRUPTED: Final = "the agent was interrupted, and the body did not say how much was heard"


@dataclass(eq=False, slots=True)
class _Utterance:
    """An utterance that is not over.

    Attributes:
        sound: what of it was written and is not sent.
        number: number of the speech that it is; None before it has begun.
        is_ended: whether all of it was written.
        was_started: whether its first sound was told of.
        was_cleared: whether the agent has silenced it.
        cut: why no more of it is spoken; empty while it is.
        failure: the mistake for which it was broken off; empty for none.
        is_given_up: whether its end is not waited for.
        is_over: whether its end was told of.
        heard: seconds that were heard of it, once it is over.
    """

    sound: bytearray = field(default_factory=bytearray)
    number: int | None = None
    is_ended: bool = False
    was_started: bool = False
    was_cleared: bool = False
    cut: str = ""
    failure: str = ""
    is_given_up: bool = False
    is_over: bool = False
    heard: float = 0.0

    def cut_off(self, reason: str) -> None:
        """Speak no more of it."""
        self.cut = self.cut or reason
        self.sound.clear()


@dataclass(frozen=True, slots=True)
class Mark:
    """A point of an utterance: so many seconds of it."""

    utterance: _Utterance
    seconds: float

    def after(self, seconds: float) -> "Mark":
        """Return the point so many seconds later."""
        return Mark(self.utterance, self.seconds + seconds)


class SpeechWriter:
    """Speaks utterances through a body, for as long as the block runs; what is not over at its end is silenced.

    An utterance begins with the first `write` and ends with `end_utterance` or `clear`. What the body does not
    speak to its end is interrupted: the rest of it is dropped, and the next one is tried again.

    Args:
        speaking: the speech of the body, of which nothing else makes use.

    Attributes:
        started: told when viewers hear the first sound of an utterance.
        broken_off: told when an utterance ends early, and not by `clear`, with why: the body was stopped, taken or
            lost, or there was a mistake, which is logged. `finished` is told right after it.
        finished: told once for each utterance, in their order, what became of it; `started` was told before if anything
            of it was heard.
    """

    def __init__(self, speaking: Speaking) -> None:
        self.started: Listeners[()] = Listeners()
        self.broken_off: Listeners[str] = Listeners()
        self.finished: Listeners[Spoken] = Listeners()
        self._speaking = speaking
        self._piece = round(speaking.rate * _PIECE) * _SAMPLE
        self._most = round(speaking.rate * MAX_WRITTEN) * _SAMPLE
        self._utterances: deque[_Utterance] = deque()
        """Those that are not over; the first one is spoken."""
        self._writing: _Utterance | None = None
        self._written = 0
        self._is_closed = False
        self._silencing: asyncio.Task[None] | None = None
        self._tasks = TaskScope()
        self._news = News()

    async def __aenter__(self) -> Self:
        self._tasks.start(self._speak_all())
        self._tasks.start(self._follow())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Silence what is not over, and tell of its end."""
        self._is_closed = True
        self.clear()
        try:
            with suppress(TimeoutError):
                async with asyncio.timeout(2 * _ANSWER):
                    await self.until_over()
        finally:
            await self._tasks.__aexit__(kind, error, trace)

    @property
    def rate(self) -> int:
        """Samples a second of what is written."""
        return self._speaking.rate

    @property
    def waiting(self) -> float:
        """Seconds of sound that were written and are not sent."""
        return _seconds(sum(len(each.sound) for each in self._utterances), self.rate)

    @property
    def written(self) -> float:
        """Seconds that were written of the present utterance; 0 between two of them."""
        return 0.0 if self._writing is None else _seconds(self._written, self.rate)

    @property
    def position(self) -> float:
        """Seconds that were heard of the utterance that is spoken now, as far as the body has told; 0 without one."""
        return self._speaking.played if self._utterances and self._utterances[0].number is not None else 0.0

    async def write(self, sound: bytes | NDArray[np.int16]) -> None:
        """Write on; waits while `MAX_WRITTEN` seconds wait. What `clear` finds waiting here is dropped.

        Args:
            sound: mono, 16 bits: an array, or bytes of little-endian samples.

        Raises:
            ValueError: it is not such sound.
            RuntimeError: the block has ended.
        """
        if self._is_closed:
            raise RuntimeError("write within the block of the SpeechWriter: it has ended, and speaks no more")
        data = _bytes(sound)
        if not data:
            return
        utterance = self.mark().utterance
        for first in range(0, len(data), self._piece):
            piece = data[first : first + self._piece]
            await self._until_room(utterance, len(piece))
            if utterance.cut:
                return
            utterance.sound += piece
            self._written += len(piece)
            self._news.notify()

    def mark(self) -> Mark:
        """Return the end of what was written of the present utterance; without one, one begins."""
        if self._writing is None:
            self._writing, self._written = _Utterance(), 0
            self._utterances.append(self._writing)
        return Mark(self._writing, self.written)

    def end_utterance(self) -> None:
        """End the present utterance: all of it was written. Without one nothing happens."""
        if self._writing is not None:
            self._writing.is_ended = True
            self._writing = None
            self._news.notify()

    def clear(self) -> None:
        """Silence all that was written, at once; of each utterance is told how much was heard."""
        self._writing = None
        for utterance in self._utterances:
            utterance.was_cleared = utterance.was_cleared or not utterance.cut
            utterance.cut_off(_CLEARED)
        if self._utterances and (self._silencing is None or self._silencing.done()):
            self._silencing = self._tasks.start(self._silence(tuple(self._utterances)))
        self._news.notify()

    async def until_heard(self, mark: Mark) -> bool:
        """Wait until an utterance was heard up to a point, or is over; return whether it was heard so far."""
        utterance = mark.utterance
        await self._news.until(lambda: utterance.is_over or utterance.was_started)
        if not utterance.is_over:
            await self._until_played(mark)
        return utterance.was_started and (not utterance.is_over or utterance.heard >= mark.seconds - _ROUNDED)

    async def until_ended(self, mark: Mark) -> None:
        """Wait until the utterance of a point is over."""
        await self._news.until(lambda: mark.utterance.is_over)

    async def until_over(self) -> None:
        """Wait until every utterance that was written is over."""
        await self._news.until(lambda: not self._utterances)

    async def _until_played(self, mark: Mark) -> None:
        # The body may never say how much it played, and the utterance is given up.
        seconds = mark.seconds - _ROUNDED
        playing = asyncio.ensure_future(self._speaking.until_played(seconds))
        playing.add_done_callback(lambda _: self._news.notify())
        try:
            await self._news.until(
                lambda: mark.utterance.is_over or (playing.done() and self._speaking.played >= seconds)
            )
        finally:
            playing.cancel()

    async def _until_room(self, utterance: _Utterance, size: int) -> None:
        def has_room() -> bool:
            # Each of the others counts, however short it is, so that their number is bounded, too.
            others = sum(max(len(each.sound), self._piece) for each in self._utterances if each is not utterance)
            return others + len(utterance.sound) + size <= self._most

        await self._news.until(lambda: utterance.cut or has_room())

    async def _speak_all(self) -> None:
        while True:
            await self._news.until(lambda: self._utterances)
            utterance = self._utterances[0]
            if self._silencing is not None:
                # What it silences must not be the next utterance.
                await asyncio.wait({self._silencing})
            spoken = await self._speak(utterance)
            self._tell_over(utterance, spoken)

    async def _speak(self, utterance: _Utterance) -> Spoken:
        """Speak one utterance to its end, and return what was heard of it."""
        try:
            while not utterance.cut:
                piece = bytes(utterance.sound[: self._piece])
                if not piece and utterance.is_ended:
                    break
                if not piece:
                    await self._news.until(lambda: utterance.sound or utterance.is_ended or utterance.cut)
                    continue
                del utterance.sound[: self._piece]
                self._news.notify()
                await self._speaking.push(np.frombuffer(piece, "<i2"))
                # The first piece waits for no credit, so that this is before the body tells of it.
                utterance.number = self._speaking.utterance
        except Aborted as error:
            utterance.cut_off(str(error))
        except ConnectionLost as error:
            # There is none where a speech has begun.
            utterance.cut_off(str(error))
        except Exception as error:
            await self._break_off(utterance, error)
        if utterance.number is None:
            return Spoken(0.0, utterance.cut)
        spoken = await self._heard(utterance)
        return Spoken(spoken.seconds, utterance.failure) if utterance.failure else spoken

    async def _heard(self, utterance: _Utterance) -> Spoken:
        """Return what was heard of an utterance of which all was sent that will be."""
        finishing = asyncio.ensure_future(self._speaking.finish())
        finishing.add_done_callback(lambda _: self._news.notify())
        try:
            await self._news.until(lambda: finishing.done() or utterance.is_given_up)
            return finishing.result() if finishing.done() else Spoken(self._speaking.played, _INTERRUPTED)
        except Exception as error:
            # Else the next utterance would go on with this speech.
            await self._break_off(utterance, error)
            return Spoken(self._speaking.played, utterance.failure)
        finally:
            finishing.cancel()

    async def _break_off(self, utterance: _Utterance, error: Exception) -> None:
        """Speak no more of an utterance, for a mistake."""
        _log.error("an utterance is broken off", exc_info=error)
        utterance.failure = utterance.failure or str(error) or type(error).__name__
        utterance.cut_off(utterance.failure)
        # `write` may wait for room, and the body still speak what it has.
        self._news.notify()
        await self._silence((utterance,))

    async def _silence(self, utterances: tuple[_Utterance, ...]) -> None:
        try:
            async with asyncio.timeout(_ANSWER):
                await self._speaking.clear()
                return
        except TimeoutError:
            pass
        except Exception:
            _log.exception("the body could not be told to be silent")
        for utterance in utterances:
            utterance.is_given_up = True
        self._news.notify()

    async def _follow(self) -> None:
        """Read what the body tells of each utterance; a mistake in that breaks off the one that is spoken."""
        while True:
            await self._news.until(lambda: self._utterances)
            try:
                async for step in self._speaking.events():
                    self._handle(step)
                return
            except Exception as error:
                if self._utterances:
                    mark = Mark(self._utterances[0], 0.0)
                    await self._break_off(mark.utterance, error)
                    # A mistake that comes again ends each utterance once.
                    await self.until_ended(mark)
                else:
                    _log.exception("what the body tells of its last utterance cannot be read")

    def _handle(self, step: Started | Starved | Finished | Refused) -> None:
        utterance = self._utterances[0] if self._utterances else None
        if utterance is None or utterance.number != step.utterance:
            return
        if isinstance(step, Started):
            self._tell_started(utterance)
        elif isinstance(step, Finished | Refused) and step.reason:
            # More of it may be waited for.
            utterance.cut_off(step.reason)
            self._news.notify()

    def _tell_started(self, utterance: _Utterance) -> None:
        if not utterance.was_started:
            utterance.was_started = True
            self._news.notify()
            self.started.notify_all()

    def _tell_over(self, utterance: _Utterance, spoken: Spoken) -> None:
        self._utterances.popleft()
        utterance.cut_off(spoken.reason)
        utterance.is_over, utterance.heard = True, spoken.seconds
        self._news.notify()
        if spoken.seconds:
            with _logged():
                self._tell_started(utterance)
        if spoken.interrupted and not utterance.was_cleared:
            with _logged():
                self.broken_off.notify_all(spoken.reason)
        with _logged():
            self.finished.notify_all(spoken)


@contextmanager
def _logged() -> Iterator[None]:
    """Log what a listener raises: the next utterance is spoken all the same."""
    try:
        yield
    except Exception:
        _log.exception("the end of an utterance was not told")


def _seconds(size: int, rate: int) -> float:
    return size / _SAMPLE / rate


def _bytes(sound: bytes | NDArray[np.int16]) -> bytes:
    if isinstance(sound, np.ndarray):
        if sound.dtype != np.int16 or sound.ndim != 1:
            raise ValueError(f"sound must be int16 of the shape (n,), not {sound.dtype} of {sound.shape}")
        return sound.astype("<i2").tobytes()
    if len(sound) % _SAMPLE:
        raise ValueError(f"sound must be whole samples of {_SAMPLE} bytes, not {len(sound)} bytes")
    return sound
