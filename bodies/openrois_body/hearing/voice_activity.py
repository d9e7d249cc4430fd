"""Voice activity: sound with a gliding pitch and a changing spectrum, as only voices have. Pure.

Tones, beeps and most instruments hold a pitch and jump to the next, noise has none, engines keep their spectrum; all of
them are told from speech by that. A voice that sings over music, or a trombone, is not: what is heard then is for the
recogniser to refuse.
"""

from collections import deque
from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.downsample import SPEECH_RATE

from openrois_body.hearing.noise_floor import Loudness
from openrois_body.hearing.voice_frames import HOP, SPAN, Moment, measure

__all__ = ["END_SILENCE", "LONGEST", "PREROLL", "Turn", "VoiceActivity"]

END_SILENCE: Final = 0.6
"""Seconds without sound after which speech has ended; a pause between words is shorter."""
LONGEST: Final = 15.0
"""Seconds after which an utterance is cut: speech that goes on is the next one."""
PREROLL: Final = 0.3
"""Seconds before the first voiced sound that may belong to speech: an unvoiced consonant."""
_INTERVAL: Final = HOP / SPEECH_RATE
_LOOKED_AT: Final = 25
"""Moments of one window: a quarter of a second, about a syllable."""
_ENOUGH: Final = 10
"""Moments of them that have to be loud."""
_GLIDING: Final = 7
"""Steps of pitch among them that have to glide as a voice does."""
_STEP: Final = (2 / 1200, 200 / 1200)
"""Octaves by which a voice's pitch moves in 10 ms: more than 2 cents, and it does not jump."""
_VARIATION: Final = 1.5
"""dB by which the bands of the spectrum vary within a syllable; of noise they do less."""
_FLUX: Final = 0.7
"""dB by which they change in 10 ms; tones that wander do less."""
_PURE_AT_MOST: Final = 0.45
"""Of the moments: a whistle or a siren glides too, but has one frequency at a time."""
_UNLIKELY: Final = round(1.5 / _INTERVAL)
"""Moments without speech-like sound after which a continuing sound is no speech any more."""


class Turn(NamedTuple):
    """Speech began or ended: `at` is the sample, counted from the first that was added, at which it did."""

    speaking: bool
    at: int


class VoiceActivity:
    """Detects the beginning and end of speech in sound at 16 kHz, in blocks of any length.

    Speech is noticed 0.1 to 0.25 s after it began, its end `END_SILENCE` after it ended.
    """

    def __init__(self) -> None:
        self.speaking = False
        """Whether there is speech now."""
        self._waiting = np.zeros(0, np.int16)
        self._measured = 0
        """Number of moments so far."""
        self._loudness = Loudness(_INTERVAL, hold=END_SILENCE)
        self._last: deque[tuple[bool, Moment]] = deque(maxlen=_LOOKED_AT)
        self._began = self._loud_at = self._likely_at = 0

    def add(self, samples: NDArray[np.int16]) -> list[Turn]:
        """Add a block of shape (n,), and return the beginnings and ends of speech in it."""
        self._waiting = np.concatenate((self._waiting, samples))
        turns = []
        while len(self._waiting) >= SPAN:
            turn = self._add_moment(measure(self._waiting[:SPAN]))
            self._waiting = self._waiting[HOP:]
            if turn is not None:
                turns.append(turn)
        return turns

    def _add_moment(self, moment: Moment) -> Turn | None:
        loud = self._loudness.add(moment.level)
        self._last.append((loud, moment))
        number, self._measured = self._measured, self._measured + 1
        if loud:
            self._loud_at = number
        likely = self._is_like_speech()
        if likely:
            self._likely_at = number
        if not self.speaking:
            return self._begin(number) if likely else None
        if not self._loudness.loud:
            return self._end_turn(self._loud_at)
        if number - self._likely_at > _UNLIKELY:
            return self._end_turn(self._likely_at)
        if (number - self._began) * _INTERVAL > LONGEST:
            return self._end_turn(number)
        return None

    def _begin(self, number: int) -> Turn:
        self.speaking, self._began = True, number
        first = number - next(
            (back for back, (loud, _) in enumerate(reversed(self._last)) if not loud), len(self._last)
        )
        return Turn(True, max(0, first + 1) * HOP)

    def _end_turn(self, number: int) -> Turn:
        self.speaking = False
        self._last.clear()
        return Turn(False, number * HOP + SPAN)

    def _is_like_speech(self) -> bool:
        heard = [moment for loud, moment in self._last if loud]
        if len(heard) < _ENOUGH or _gliding(self._last) < _GLIDING:
            return False
        shapes = np.array([moment.shape for moment in heard])
        varies = shapes.std(axis=0).mean() >= _VARIATION and np.abs(np.diff(shapes, axis=0)).mean() >= _FLUX
        return bool(varies) and sum(moment.pure for moment in heard) <= _PURE_AT_MOST * len(heard)


def _gliding(moments: Iterable[tuple[bool, Moment]]) -> int:
    """Return the number of gliding steps of pitch that follow a gliding step: beats and drums make single ones."""
    count, before, glided = 0, None, False
    for loud, moment in moments:
        pitch = moment.pitch if loud else None
        glides = before is not None and pitch is not None and _STEP[0] < abs(pitch - before) < _STEP[1]
        count += glides and glided
        before, glided = pitch, glides
    return count
