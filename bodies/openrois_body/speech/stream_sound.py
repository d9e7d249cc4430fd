"""The sound of a speech that comes as a stream: samples or Opus in, samples of 48 kHz out."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.input.messages import InputError
from openrois_streaming.input.speech import SpeechFormat
from openrois_streaming.receive.decoders import OpusDecoder
from openrois_streaming.receive.playout import UndecodableSound
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.speech.resample import Resampler

__all__ = ["StreamSound"]

_SAMPLE: Final = np.dtype("<i2")


class StreamSound:
    """Decodes the sound of one speech, and resamples it.

    Args:
        format: its coding.
        rate: of samples that are not coded, and of those that are counted, in Hz.
    """

    def __init__(self, format: SpeechFormat, rate: int) -> None:
        self._factor = SAMPLE_RATE // rate
        self._decoder = OpusDecoder() if format == "opus" else None
        self._resampler = Resampler(SAMPLE_RATE if format == "opus" else rate)

    def read(self, sound: bytes) -> NDArray[np.int16]:
        """Return the samples (mono) of a frame, not resampled yet.

        Raises:
            InputError: it cannot be decoded.
        """
        if self._decoder is None:
            if len(sound) % _SAMPLE.itemsize:
                raise InputError(f"a frame has whole samples of 2 bytes, not {len(sound)} bytes")
            return np.frombuffer(sound, _SAMPLE)
        try:
            return np.ascontiguousarray(self._decoder.decode(sound)[:, 0])
        except UndecodableSound as error:
            raise InputError(f"a packet of Opus cannot be decoded: {error}") from error

    def count(self, samples: NDArray[np.int16]) -> int:
        """Return how many samples those of a frame are at the rate that is counted in."""
        return len(samples) if self._decoder is None else len(samples) // self._factor

    def resample(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return the next samples of 48 kHz; a few are kept until `finish`."""
        return self._resampler.add(samples)

    def finish(self) -> NDArray[np.int16]:
        """Return the samples that were kept."""
        return self._resampler.finish()

    def counted(self, samples: int) -> int:
        """Return how many samples of 48 kHz are at the rate that is counted in."""
        return samples // self._factor
