"""The camera and the microphone of the browser: files that it plays again and again."""

import wave
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tests.support.people import Scene, write_y4m

__all__ = ["Devices"]

_RATE: Final = 48_000


@dataclass(frozen=True, slots=True)
class Devices:
    """What the camera sees and the microphone hears from when a page opens them.

    Attributes:
        folder: where both are kept.
    """

    folder: Path

    def see(self, scene: Scene, seconds: float) -> None:
        """Put people in front of the camera."""
        new = self.folder / "new.y4m"
        write_y4m(new, scene, seconds)
        new.replace(self._film)  # a page that still looks keeps its own

    def hear(self, sound: NDArray[np.int16]) -> None:
        """Let a sound be heard (n; 48 kHz)."""
        with wave.open(str(self._sound), "wb") as file:
            file.setparams((1, 2, _RATE, 0, "NONE", ""))
            file.writeframes(sound.tobytes())

    def hear_beeps(self) -> None:
        """Let a tone be heard for a fifth of every second."""
        time = np.arange(_RATE) / _RATE
        self.hear((10_000 * np.sin(2000 * np.pi * time) * (time < 0.2)).astype(np.int16))

    @property
    def arguments(self) -> tuple[str, ...]:
        """The options with which Chromium uses them, and grants every permission."""
        return (
            "--use-fake-device-for-media-stream",
            "--use-fake-ui-for-media-stream",
            f"--use-file-for-fake-video-capture={self._film}",
            f"--use-file-for-fake-audio-capture={self._sound}",
        )

    @property
    def _film(self) -> Path:
        return self.folder / "film.y4m"

    @property
    def _sound(self) -> Path:
        return self.folder / "sound.wav"
