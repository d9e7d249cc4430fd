"""Sound that arrives as bytes, raw or as a WAV file, becomes samples of 48 kHz, piece by piece. Pure."""

import struct
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrois_body.speech.resample import RATES, Resampler

__all__ = ["MAX_HEADER", "SoundReader", "UnknownSound"]

MAX_HEADER: Final = 4096
"""Bytes of a WAV file before its sound."""
_RIFF: Final = b"RIFF"
_CHUNK: Final = struct.Struct("<4sI")
_FORMAT: Final = struct.Struct("<HHIIHH")
_PCM: Final = (0x0001, 0xFFFE)
_BITS: Final = 16
_FULL: Final = 100


class UnknownSound(ValueError):
    """Sound that cannot be read; the text says why."""


class SoundReader:
    """Reads samples of 16 bits; what begins as a WAV file says itself how it is made.

    Args:
        rate: of raw sound, in Hz; it is mono and little-endian.
        volume: 0 to 100.

    Raises:
        UnknownSound: sound of this rate is not resampled.
    """

    def __init__(self, rate: int, volume: int = _FULL) -> None:
        self._resampler = _resampler(rate)
        self._loudness = np.float32(min(_FULL, max(0, volume)) / _FULL)
        self._channels = 1
        self._rest = b""
        self._has_begun = False
        """Whether the sound has begun: the header, if there is one, was read."""

    def add(self, data: bytes) -> NDArray[np.int16]:
        """Return the samples (mono, 48 kHz) that are complete with more bytes.

        Raises:
            UnknownSound: it is a WAV file, but not of 16 bits, one or two channels, and a rate that is resampled.
        """
        self._rest += data
        if not self._has_begun and not self._begin():
            return np.zeros(0, np.int16)
        size = 2 * self._channels
        count = len(self._rest) // size * size
        whole, self._rest = self._rest[:count], self._rest[count:]
        samples = np.frombuffer(whole, "<i2").reshape(-1, self._channels)
        return self._loud(self._resampler.add(_mixed(samples)))

    def finish(self) -> NDArray[np.int16]:
        """Return the rest; half a sample at the end is dropped."""
        return self._loud(self._resampler.finish())

    def _loud(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        loud: NDArray[np.int16] = np.rint(samples * self._loudness).astype(np.int16)
        return loud

    def _begin(self) -> bool:
        """Read the header, if there is one; returns whether the sound has begun."""
        if not self._rest.startswith(_RIFF):
            self._has_begun = len(self._rest) >= len(_RIFF) or not _RIFF.startswith(self._rest)
            return self._has_begun
        place = 12
        known = False
        while len(self._rest) >= place + _CHUNK.size:
            name, size = _CHUNK.unpack_from(self._rest, place)
            place += _CHUNK.size
            if name == b"data":
                if not known:
                    raise UnknownSound("the WAV file does not say how it is made")
                self._rest, self._has_begun = self._rest[place:], True
                return True
            if name == b"fmt " and len(self._rest) >= place + _FORMAT.size:
                self._read_format(_FORMAT.unpack_from(self._rest, place))
                known = True
            place += size + size % 2
        if max(len(self._rest), place) > MAX_HEADER:
            raise UnknownSound(f"the WAV file has no sound within its first {MAX_HEADER} bytes")
        return False

    def _read_format(self, told: tuple[int, ...]) -> None:
        kind, channels, rate, _, _, bits = told
        if kind not in _PCM or bits != _BITS or channels not in {1, 2}:
            raise UnknownSound(
                f"the WAV file has format {kind}, {channels} channels and {bits} bits, not PCM of 16 bits"
            )
        self._resampler, self._channels = _resampler(rate), channels


def _mixed(samples: NDArray[np.int16]) -> NDArray[np.int16]:
    mixed: NDArray[np.int16] = samples[:, 0] if samples.shape[1] == 1 else samples.mean(axis=1).astype(np.int16)
    return mixed


def _resampler(rate: int) -> Resampler:
    if rate not in RATES:
        raise UnknownSound(f"sound of {rate} Hz is not played; ask for one of {', '.join(map(str, RATES))}")
    return Resampler(rate)
