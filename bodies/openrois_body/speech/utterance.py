"""The playout of a speech whose sound comes while it is played: it can be cut off and paused, and may run dry."""

import asyncio
import secrets
from bisect import insort
from collections import deque
from collections.abc import Callable, Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import wall_at
from openrois_streaming.source.source import SAMPLE_RATE

from openrois.errors import Aborted
from openrois.types.codes import CompletedStatus
from openrois_body.body import Body
from openrois_body.messages import MAX_VISEMES, Speak, Viseme
from openrois_body.sound.mixer import BodySound, SoundBusy
from openrois_body.sound.playback import AHEAD_LIMIT, Playback, SoundOverrun, reach
from openrois_body.speech.contract import NamedMark, Word
from openrois_body.speech.lips import Lips, SoundLips
from openrois_body.speech.mouth import SoundMouth
from openrois_body.speech.playout_delay import PlayoutDelay
from openrois_body.speech.progress import MarkReached, Progress, SpeechBegan, SpeechEnded, SpeechStarved, WordSpoken
from openrois_body.speech.turns import Line, Turn

__all__ = ["DRY_LIMIT", "MOMENTS_LIMIT", "Utterance", "place_of"]

MOMENTS_LIMIT: Final = 4_000
"""Words and marks of one speech that may wait until they are heard."""
DRY_LIMIT: Final = 30.0
"""Seconds without sound after which a speech that has not been finished ends: others wait behind it."""
_STEP: Final = 0.1
"""Seconds between two reports of what was played."""
_KNOWN: Final = 0.2
"""Seconds for which the delay to the viewers is not asked for again."""


class Utterance:
    """Plays sound through the body, after all speeches before it, and moves the mouth with it.

    Sound, words and marks are given to it before `play` or while it runs; `play` ends when all was heard after
    `finish`, or when it is cut off. `Voice.make_utterance` makes one, `Voice.utter` plays it.

    Args:
        sound: the body's sound.
        body: moves the mouth.
        playout_delay: of the viewers that hear it.
        on_progress: called with each step, in order; must not raise.
        line: the order of the voice's speeches.
        text: what is spoken, as far as it is known; empty if it is not.
        is_ssml: whether `text` is SSML.
        lips: give the shapes of its mouth; those that are read from the sound unless given.
        on_played: called with the samples that have been played, ten times a second while there are some.
    """

    def __init__(
        self,
        sound: BodySound,
        body: Body,
        playout_delay: PlayoutDelay,
        on_progress: Callable[[Progress], None],
        line: Line,
        *,
        text: str = "",
        is_ssml: bool = False,
        lips: Lips | None = None,
        on_played: Callable[[int], None] = lambda _samples: None,
    ) -> None:
        self.speech_id = secrets.token_hex(8)
        self.over = asyncio.Event()
        """Set when `play` has returned or raised."""
        self._text = text
        self._is_ssml = is_ssml
        self._sound = sound
        self._body = body
        self._playout_delay = playout_delay
        self._on_progress = on_progress
        self._line = line
        self._lips = lips or SoundLips(SoundMouth())
        self._on_played = on_played
        self._waiting: deque[NDArray[np.int16]] = deque()
        """Sound that has no place in time yet."""
        self._moments: list[Word | NamedMark] = []
        """Words and marks that are not heard yet, in order of time."""
        self._pushed = 0
        self._former = 0
        """Samples that were heard before the present playback: before a pause."""
        self._playback: Playback | None = None
        self._turn: Turn | None = None
        self._finished = False
        self._cut_off = ""
        self._has_begun = False
        self._dry_at = 0
        """How many samples had come when it was last told that it ran dry."""
        self._dry_until = 0.0
        """When it ends unless sound comes."""
        self._last: Word | None = None
        self._late = 0.0
        self._late_at = float("-inf")
        self._news = asyncio.Event()
        self._moved = asyncio.Event()
        self._going_on = asyncio.Event()
        self._going_on.set()

    @property
    def played(self) -> int:
        """The number of its samples that were played by now; viewers hear them a little later."""
        return self._former + (0 if self._playback is None else self._playback.played)

    @property
    def ahead(self) -> float:
        """Seconds of sound that wait to be played."""
        return (self._pushed - self.played) / SAMPLE_RATE

    @property
    def is_ended(self) -> bool:
        """Whether it takes no more sound."""
        return self._finished or bool(self._cut_off) or self.over.is_set()

    def push(self, samples: NDArray[np.int16]) -> None:
        """Append sound (mono, 48 kHz). What comes after `finish` or `cut` is dropped.

        Raises:
            SoundOverrun: more than `AHEAD_LIMIT` seconds of it wait.
        """
        if self.is_ended or not len(samples):
            return
        if self.ahead + len(samples) / SAMPLE_RATE > AHEAD_LIMIT:
            raise SoundOverrun(
                f"more than {AHEAD_LIMIT:g} seconds of sound wait to be played; wait before you push more"
            )
        self._pushed += len(samples)
        playback = self._playback
        if playback is None or playback.is_settled:
            self._waiting.append(samples)
        else:
            self._append(playback, samples)
            self._news.set()

    def add_moments(self, moments: Iterable[Word | NamedMark]) -> None:
        """Add words and marks, in any order; those of sound that was heard already are told at once.

        Raises:
            SoundOverrun: more than `MOMENTS_LIMIT` wait.
        """
        for moment in moments:
            if len(self._moments) >= MOMENTS_LIMIT:
                raise SoundOverrun(f"more than {MOMENTS_LIMIT} words and marks wait to be heard; send them later")
            insort(self._moments, moment, key=lambda each: each.offset_ms)
        self._news.set()

    def finish(self) -> None:
        """Set the end: behind the last sound that was pushed. Idempotent."""
        self._finished = True
        self._news.set()
        if self._playback is not None and not self._playback.is_settled:
            self._settle(self._playback)

    def cut(self, why: str) -> None:
        """Cut it off within a block of sound (20 ms); the sentence of `Aborted` begins with `why`."""
        self._cut_off = self._cut_off or why
        self._fall_silent()
        self._going_on.set()

    def pause(self) -> None:
        """Fall silent within a block of sound; what is pushed meanwhile waits."""
        self._going_on.clear()
        self._fall_silent()

    def go_on(self) -> None:
        """Resume where it was paused."""
        self._going_on.set()

    async def room(self, seconds: float) -> None:
        """Wait until less than so many seconds of sound wait to be played, or it is over."""
        while self.ahead >= seconds and not (self._cut_off or self.over.is_set()):
            self._moved.clear()
            await self._moved.wait()

    async def play(self) -> None:
        """Play until all was heard. Cancelling this cuts it off.

        Raises:
            Aborted: it was cut off; the sentence says why and where.
            SoundBusy: too many speeches wait.
        """
        status, reason = CompletedStatus.OK, ""
        try:
            while True:
                await self._going_on.wait()
                if self._cut_off:
                    raise Aborted(f"{self._cut_off} {self._place()}")
                if await self._play():
                    return
        except asyncio.CancelledError:
            status, reason = CompletedStatus.ABORT, f"the speech was stopped {self._place()}"
            raise
        except Aborted as error:
            status, reason = CompletedStatus.ABORT, str(error)
            raise
        except SoundBusy as error:
            status, reason = CompletedStatus.OUT_OF_RESOURCES, str(error)
            raise
        finally:
            self._waiting.clear()
            self._moments.clear()
            self.over.set()
            self._moved.set()
            ended = SpeechEnded(
                self.speech_id, status, reason, self._last, self._sound.clock.wall(), self._former * 1000 // SAMPLE_RATE
            )
            self._on_progress(ended)

    def _place(self) -> str:
        if self._last is not None:
            return place_of(self._last)
        return f"{self._former / SAMPLE_RATE:.1f} s after its first sound" if self._former else "before its first sound"

    def _fall_silent(self) -> None:
        if self._turn is not None:
            self._turn.give_up()
        if self._playback is not None:
            self._playback.stop()
        self._news.set()
        self._moved.set()

    async def _play(self) -> bool:
        """Play from the first sound that waits on; returns whether all was heard."""
        turn = self._turn = self._line.join()
        try:
            if not await turn.comes():
                return False
            playback = self._playback = self._sound.play()
            heard = False
            try:
                self._dry_until = self._sound.clock.now() + DRY_LIMIT
                while self._waiting:
                    self._append(playback, self._waiting.popleft())
                if self._finished:
                    self._settle(playback)
                heard = await self._follow(playback)
            finally:
                self._end(playback, heard)
            return heard
        finally:
            self._turn = None
            turn.pass_on()

    def _end(self, playback: Playback, heard: bool) -> None:
        self._playback = None
        if heard:
            self._body.spoken(self.speech_id)
        else:
            playback.stop()
            if playback.pushed:
                self._body.silence()
            rest = playback.take_rest()
            if len(rest):
                self._waiting.appendleft(rest)
            # What was handed out before the stop is on its way to the viewers.
            while self._moments and self._position(self._moments[0]) < playback.heard:
                self._tell(self._moments.pop(0), playback)
        self._former += playback.heard
        self._lips.restart(self._former)

    async def _follow(self, playback: Playback) -> bool:
        """Tell what is heard until all was, or it is stopped; returns whether all was heard."""
        clock = self._sound.clock
        while True:
            self._news.clear()
            if playback.is_stopped:
                return False
            late = await self._lateness()
            now = clock.now()
            self._on_played(self.played)
            self._moved.set()
            self._move(playback)
            due = [*self._tell_heard(playback, now - late), *self._tell_dry(playback, now)]
            if self._finished:
                end = playback.end
                if end is None:
                    return True
                if now >= end + late:
                    # The viewers' delay may have grown since it was asked for.
                    late = await self._lateness(known=0.0)
                if now >= end + late:
                    return True
                due.append(end + late)
            elif now >= self._dry_until:
                self.cut(f"no sound came for {DRY_LIMIT:g} s, and the speech ended")
                return False
            else:
                due.append(self._dry_until)
            if self.played < self._pushed:
                due.append(now + _STEP)
            await reach(clock, min(due), self._news)

    def _tell_heard(self, playback: Playback, heard: float) -> list[float]:
        """Tell what is heard by a moment of the sound; returns when the next is, by the clock."""
        first = playback.moment(0)
        if first is None:
            return []
        if not self._has_begun:
            if first > heard:
                return [first + self._late]
            self._begin(first)
        while self._moments:
            moment = playback.moment(max(0, self._position(self._moments[0])))
            if moment is None:
                return []
            if moment > heard:
                return [moment + self._late]
            self._tell(self._moments.pop(0), playback)
        return []

    def _tell_dry(self, playback: Playback, now: float) -> list[float]:
        """Tell that it has run dry, once each time; returns when it will, by the clock."""
        end = playback.end
        if self._finished or end is None or self._dry_at == self._pushed:
            return []
        if now < end:
            return [end]
        self._dry_at = self._pushed
        at = wall_at(self._sound.clock, end + self._late)
        self._on_progress(SpeechStarved(self.speech_id, self._pushed * 1000 // SAMPLE_RATE, at))
        return []

    def _position(self, moment: Word | NamedMark) -> int:
        """Return the sample of the present playback at which a word or mark begins."""
        return round(moment.offset_ms * SAMPLE_RATE / 1000) - self._former

    def _begin(self, moment: float) -> None:
        self._has_begun = True
        at = wall_at(self._sound.clock, moment + self._late)
        self._on_progress(SpeechBegan(self.speech_id, self._text, self._is_ssml, at))

    def _tell(self, moment: Word | NamedMark, playback: Playback) -> None:
        begins = playback.moment(max(0, self._position(moment)))
        begins = self._sound.clock.now() if begins is None else begins
        if not self._has_begun:
            self._begin(begins)
        at = wall_at(self._sound.clock, begins + self._late)
        if isinstance(moment, Word):
            self._last = moment
            self._on_progress(WordSpoken(self.speech_id, moment.text, moment.position, at))
        else:
            self._on_progress(MarkReached(self.speech_id, moment.name, at))

    def _settle(self, playback: Playback) -> None:
        """Set the end of the playback, which the next speech waits for."""
        playback.finish()
        self._move(playback)
        if self._turn is not None:
            self._turn.set_end(playback.end or self._sound.clock.now())

    def _append(self, playback: Playback, samples: NDArray[np.int16]) -> None:
        self._dry_until = playback.push(samples) + len(samples) / SAMPLE_RATE + DRY_LIMIT
        self._lips.push(samples)
        self._move(playback)

    def _move(self, playback: Playback) -> None:
        """Move the mouth to the sound that is played soon."""
        movements: list[Speak] = []
        for shapes in self._lips.read_shapes(self.ahead, is_whole=playback.is_settled):
            begin = shapes.visemes[0].offset_ms
            start = playback.moment(round(begin * SAMPLE_RATE / 1000))
            if start is None or shapes.until_ms <= begin:
                continue
            visemes = tuple(
                Viseme(each.offset_ms - begin, each.shape, each.weight) for each in shapes.visemes[:MAX_VISEMES]
            )
            duration = round(shapes.until_ms - begin)
            movements.append(Speak(self.speech_id, round(start * 1e9), visemes, duration))
        if movements:
            self._body.speak(self.speech_id, movements)

    async def _lateness(self, known: float = _KNOWN) -> float:
        """Return the delay to the viewers; one that was asked for so many seconds ago will do."""
        now = self._sound.clock.now()
        if now - self._late_at >= known:
            self._late = self._sound.lag + await self._playout_delay.lateness()
            self._late_at = now
        return self._late


def place_of(word: Word | None) -> str:
    """Return where a speech was cut off, for a sentence: at the last word that was begun."""
    return "before the first word" if word is None else f"at the word {word.text!r} (character {word.position})"
