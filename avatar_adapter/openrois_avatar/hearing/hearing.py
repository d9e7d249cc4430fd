"""Hearing speech: that somebody speaks, for those who attend, such as a voice that is to fall silent; and its sound."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import RawAudio

from openrois.aio.listeners import Listeners
from openrois_avatar.hearing.downsample import SPEECH_RATE, Downsampler
from openrois_avatar.hearing.ear import Ear
from openrois_avatar.hearing.voice_activity import PREROLL, VoiceActivity

__all__ = ["Hearing"]

_KEPT: Final = round((PREROLL + 0.7) * SPEECH_RATE)
"""Samples that are kept while nobody speaks: speech is noticed a while after it began."""


class Hearing:
    """Tells when the operator speaks. Speech is looked for while somebody attends, and only then.

    All times are seconds of the media clock at which the sound was captured; speech is noticed 0.1 to 0.3 s after it
    began.

    Args:
        ear: what is heard.
    """

    def __init__(self, ear: Ear) -> None:
        self.speech_began: Listeners[float] = Listeners()
        """Are told when speech began."""
        self.speech: Listeners[NDArray[np.int16]] = Listeners()
        """Are told the sound of speech, 16 kHz mono of shape (n,), from a little before its beginning to its end."""
        self.speech_ended: Listeners[float] = Listeners()
        """Are told when it ended; every beginning has an end."""
        self._ear = ear
        self._attending: set[object] = set()
        self._leave: Callable[[], None] | None = None
        self._forget()

    @property
    def speaking(self) -> bool:
        """Whether somebody speaks now, as far as anybody attends."""
        return self._activity.speaking

    def attend(self) -> Callable[[], None]:
        """Look for speech from now on; return what ends that, however often it is called."""
        key = object()
        self._attending.add(key)
        if self._leave is None:
            self._leave = self._ear.listen(self._hear)
        return lambda: self._desert(key)

    def _desert(self, key: object) -> None:
        self._attending.discard(key)
        if not self._attending and self._leave is not None:
            self._leave()
            self._leave = None
            speaking, now = self.speaking, self._begins_at + self._taken / SPEECH_RATE
            self._forget()
            if speaking:
                self.speech_ended.tell(now)

    def _forget(self) -> None:
        self._downsampler, self._activity = Downsampler(), VoiceActivity()
        self._recent = np.zeros(0, np.int16)
        self._taken = 0
        """Samples that the activity has got, at 16 kHz."""
        self._begins_at = 0.0
        """When the first of them would have been captured, seen from the newest."""

    def _hear(self, sound: RawAudio) -> None:
        samples = self._downsampler.add(sound.samples)
        self._begins_at = sound.captured_at - self._taken / SPEECH_RATE
        self._taken += len(samples)
        self._recent = np.concatenate((self._recent, samples))[-max(_KEPT, len(samples)) :]
        if self.speaking:
            self.speech.tell(samples)
        for speaking, at in self._activity.add(samples):
            moment = self._begins_at + at / SPEECH_RATE
            if speaking:
                self.speech_began.tell(moment)
                first = self._taken - at + round(PREROLL * SPEECH_RATE)
                self.speech.tell(self._recent[-min(first, len(self._recent)) :])
            else:
                self.speech_ended.tell(moment)
