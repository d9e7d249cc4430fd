"""Speech detection: when the operator speaks, and the sound of the speech."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.downsample import SPEECH_RATE, Downsampler
from openrois_streaming.source.source import RawAudio

from openrois.aio.listeners import Listeners
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.voice_activity import PREROLL, VoiceActivity

__all__ = ["SpeechDetector"]

_KEPT: Final = round((PREROLL + 0.7) * SPEECH_RATE)
"""Samples that are kept without speech: speech is noticed a while after it began."""


class SpeechDetector:
    """Detects when the operator speaks, while at least one caller attends, and only then.

    All times are seconds of the media clock at which the sound was captured; speech is noticed 0.1 to 0.3 s after it
    began.

    Args:
        ear: the microphone's sound.
    """

    def __init__(self, ear: Ear) -> None:
        self.speech_began: Listeners[float] = Listeners()
        """Called with the time when speech began."""
        self.speech: Listeners[NDArray[np.int16]] = Listeners()
        """Called with the sound of speech, 16 kHz mono of shape (n,), from a little before its beginning to its end."""
        self.speech_ended: Listeners[float] = Listeners()
        """Called with the time when speech ended; every beginning has an end."""
        self.sound_came: Listeners[float] = Listeners()
        """Called with the capture time of each block of sound, speech or not, before what is in it is told."""
        self._ear = ear
        self._attending: set[object] = set()
        self._leave: Callable[[], None] | None = None
        self._reset()
        ear.forgotten.add(self._begin_anew)

    @property
    def speaking(self) -> bool:
        """Whether the operator speaks now; False while no caller attends."""
        return self._activity.speaking

    @property
    def sender(self) -> str:
        """The visitor_ref of whose speech it is."""
        return self._ear.sender

    def attend(self) -> Callable[[], None]:
        """Detect speech from now on; return a function that ends that, and may be called repeatedly."""
        key = object()
        self._attending.add(key)
        if self._leave is None:
            self._leave = self._ear.listen(self._on_sound)
        return lambda: self._stop_attending(key)

    def forget_sound(self) -> None:
        """Drop the sound that is kept for the beginning of the next speech."""
        self._recent = np.zeros(0, np.int16)

    def _stop_attending(self, key: object) -> None:
        self._attending.discard(key)
        if not self._attending and self._leave is not None:
            self._leave()
            self._leave = None
            self._begin_anew()

    def _begin_anew(self) -> None:
        """Forget what was heard; speech that goes on has ended."""
        speaking, now = self.speaking, self._begins_at + self._taken / SPEECH_RATE
        self._reset()
        if speaking:
            self.speech_ended.notify_all(now)

    def _reset(self) -> None:
        self._downsampler, self._activity = Downsampler(), VoiceActivity()
        self._recent = np.zeros(0, np.int16)
        self._taken = 0
        """Samples that the voice activity has got, at 16 kHz."""
        self._begins_at = 0.0
        """Capture time of the first of them, computed from the newest."""

    def _on_sound(self, sound: RawAudio) -> None:
        samples = self._downsampler.add(sound.samples)
        self._begins_at = sound.captured_at - self._taken / SPEECH_RATE
        self._taken += len(samples)
        self._recent = np.concatenate((self._recent, samples))[-max(_KEPT, len(samples)) :]
        self.sound_came.notify_all(sound.captured_at)
        if self.speaking:
            self.speech.notify_all(samples)
        for speaking, at in self._activity.add(samples):
            moment = self._begins_at + at / SPEECH_RATE
            if speaking:
                self.speech_began.notify_all(moment)
                first = self._taken - at + round(PREROLL * SPEECH_RATE)
                self.speech.notify_all(self._recent[-min(first, len(self._recent)) :])
            else:
                self.speech_ended.notify_all(moment)
