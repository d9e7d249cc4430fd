"""The playout of one text: announced word by word, it can be cut off, and paused in mid-word."""

import asyncio
import secrets
from collections import deque
from collections.abc import Callable

from openrois_streaming.clock import wall_at
from openrois_streaming.source.source import SAMPLE_RATE

from openrois.errors import Aborted
from openrois.types.codes import CompletedStatus
from openrois_body.body import Body
from openrois_body.sound.mixer import BodySound, Playback, SoundBusy
from openrois_body.speech.contract import NamedMark, Speech, Word
from openrois_body.speech.playout_delay import PlayoutDelay
from openrois_body.speech.progress import MarkReached, Progress, SpeechBegan, SpeechEnded, WordSpoken
from openrois_body.speech.turns import Line, Turn

__all__ = ["Utterance", "place_of"]


class Utterance:
    """Plays a speech through the body's sound and mouth, after all speeches before it.

    Args:
        sound: the body's sound.
        body: moves the mouth.
        playout_delay: of the viewers that hear it.
        on_progress: called with each step, in order; must not raise.
        line: the order of the voice's speeches.
        text: the application's text.
        is_ssml: whether `text` is SSML.
    """

    def __init__(
        self,
        sound: BodySound,
        body: Body,
        playout_delay: PlayoutDelay,
        on_progress: Callable[[Progress], None],
        line: Line,
        text: str,
        *,
        is_ssml: bool,
    ) -> None:
        self.speech_id = secrets.token_hex(8)
        self._text = text
        self._is_ssml = is_ssml
        self._has_begun = False
        """Whether `SpeechBegan` was sent."""
        self.begun = False
        """Whether `play` was called."""
        self.over = asyncio.Event()
        """Set when `play` has returned or raised."""
        self._sound = sound
        self._body = body
        self._playout_delay = playout_delay
        self._on_progress = on_progress
        self._line = line
        self._turn: Turn | None = None
        self._heard_before = 0
        """Samples that were heard before the present playback."""
        self._playback: Playback | None = None
        self._late = 0.0
        self._last: Word | None = None
        self._cut_off = ""
        self._going_on = asyncio.Event()
        self._going_on.set()

    async def play(self, speech: Speech) -> None:
        """Play the speech until all of it was heard. Cancelling this cuts it off.

        Raises:
            Aborted: it was cut off; the sentence has the reason and the word.
            SoundBusy: too many speeches wait.
        """
        self.begun = True
        rest: Speech | None = speech
        try:
            while rest is not None:
                await self._going_on.wait()
                if self._cut_off:
                    raise Aborted(f"{self._cut_off} {place_of(self._last)}")
                rest = await self._play(rest)
        except asyncio.CancelledError:
            self._announce_end(CompletedStatus.ABORT, f"the speech was stopped {place_of(self._last)}")
            raise
        except Aborted as error:
            self._announce_end(CompletedStatus.ABORT, str(error))
            raise
        except SoundBusy as error:
            self._announce_end(CompletedStatus.OUT_OF_RESOURCES, str(error))
            raise
        finally:
            self.over.set()
        self._announce_end(CompletedStatus.OK, "")

    def cut(self, why: str) -> None:
        """Cut the speech off within a block of sound (20 ms); the sentence of `Aborted` begins with `why`."""
        self._cut_off = why
        self._fall_silent()
        self._going_on.set()

    def pause(self) -> None:
        """Fall silent within a block of sound, in the middle of a word too."""
        self._going_on.clear()
        self._fall_silent()

    def go_on(self) -> None:
        """Resume where it was paused."""
        self._going_on.set()

    def _fall_silent(self) -> None:
        if self._turn is not None:
            self._turn.give_up()
        if self._playback is not None:
            self._playback.stop()

    async def _play(self, speech: Speech) -> Speech | None:
        """Play a speech; return its rest when it is stopped, None when all of it was heard."""
        turn = self._turn = self._line.join()
        try:
            if not await turn.comes():
                return speech
            playback = self._playback = self._sound.play(speech.samples)
            turn.set_end(playback.end)
            return await self._follow(playback, speech)
        finally:
            self._turn = None
            turn.pass_on()

    async def _follow(self, playback: Playback, speech: Speech) -> Speech | None:
        """Tell what is heard until all was, or it is stopped; returns the rest of the speech."""
        self._body.speak(self.speech_id, speech.mouth(self.speech_id, playback.start_ns))
        coming = deque(speech.moments)
        played = False
        try:
            while coming and await self._heard(playback, playback.start + coming[0].offset_ms / 1000):
                self._reached(coming.popleft(), playback)
            played = not coming and await self._heard(playback, playback.end)
        finally:
            self._playback = None
            self._heard_before += playback.heard
            if played:
                self._body.spoken(self.speech_id)
            else:
                playback.stop()
                self._body.silence()
            # Words that began before the stop are on their way to the viewers.
            while coming and coming[0].offset_ms * SAMPLE_RATE < playback.heard * 1000:
                self._reached(coming.popleft(), playback)
        return None if played else speech.after(playback.heard)

    async def _heard(self, playback: Playback, moment: float) -> bool:
        """Wait until the viewers hear a moment of the media clock; return False if the speech is stopped before."""
        late, self._late = -1.0, await self._lateness()
        while self._late > late:
            # The viewers' delay may have grown while this waited.
            late = self._late
            if not await playback.reach(moment + late):
                return False
            self._late = max(late, await self._lateness())
        return True

    async def _lateness(self) -> float:
        return self._sound.lag + await self._playout_delay.lateness()

    def _reached(self, moment: Word | NamedMark, playback: Playback) -> None:
        at = wall_at(self._sound.clock, playback.start + moment.offset_ms / 1000 + self._late)
        if not self._has_begun:
            self._has_begun = True
            self._on_progress(SpeechBegan(self.speech_id, self._text, self._is_ssml, at))
        if isinstance(moment, Word):
            self._last = moment
            self._on_progress(WordSpoken(self.speech_id, moment.text, moment.position, at))
        else:
            self._on_progress(MarkReached(self.speech_id, moment.name, at))

    def _announce_end(self, status: CompletedStatus, reason: str) -> None:
        heard_ms = self._heard_before * 1000 // SAMPLE_RATE
        self._on_progress(SpeechEnded(self.speech_id, status, reason, self._last, self._sound.clock.wall(), heard_ms))


def place_of(word: Word | None) -> str:
    """Return where a speech was cut off, for a sentence: at the last word that was begun."""
    return "before the first word" if word is None else f"at the word {word.text!r} (character {word.position})"
