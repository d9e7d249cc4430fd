"""Sound that arrives as bytes: raw, as WAV files, and as what is neither."""

import io
import struct
import wave
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from openrois_body.speech.pcm import MAX_HEADER, SoundReader, UnknownSound


def read(reader: SoundReader, data: bytes, piece: int) -> NDArray[np.int16]:
    parts = [reader.add(data[first : first + piece]) for first in range(0, len(data), piece)]
    return np.concatenate([*parts, reader.finish()])


def wav(channels: int = 1, width: int = 2, rate: int = 24_000, frames: int = 2400) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as sound:
        sound.setnchannels(channels)
        sound.setsampwidth(width)
        sound.setframerate(rate)
        sound.writeframes(b"\x10\x10" * (frames * channels * width // 2))
    return file.getvalue()


@pytest.mark.parametrize("piece", [1, 3, 1000, 1 << 20])
def test_raw_sound_may_come_in_pieces_that_cut_samples(piece: int) -> None:
    samples = np.full(2400, 1000, "<i2")
    heard = read(SoundReader(24_000), samples.tobytes(), piece)
    assert len(heard) == 4800
    assert np.abs(heard[200:-200] - 1000).max() <= 2


@pytest.mark.parametrize("piece", [1, 7, 1 << 20])
@pytest.mark.parametrize("channels", [1, 2])
def test_a_wav_file_says_itself_how_it_is_made(piece: int, channels: int) -> None:
    heard = read(SoundReader(24_000), wav(channels, rate=16_000, frames=1600), piece)
    assert len(heard) == 4800
    assert np.abs(heard[200:-200] - 0x1010).max() <= 5


def test_the_length_of_a_streamed_wav_file_is_not_believed() -> None:
    file = wav()
    endless = file[:40] + struct.pack("<I", 0xFFFFFFFF) + file[44:]
    assert len(read(SoundReader(24_000), endless, 100)) == 4800


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (wav(width=1), "format 1, 1 channels and 8 bits"),
        (wav(rate=24_001), "sound of 24001 Hz is not played; ask for one of 8000, 11025"),
        (wav(channels=3), "format 1, 3 channels"),
        (b"RIFF\0\0\0\0WAVE" + b"data" + bytes(4), "does not say how it is made"),
        (b"RIFF\0\0\0\0WAVE" + b"LIST\xff\xff\xff\x7f" + bytes(8000), f"within its first {MAX_HEADER} bytes"),
        (b"RIFF\0\0\0\0WAVE" + (b"LIST" + bytes(4)) * 1000, f"within its first {MAX_HEADER} bytes"),
    ],
)
def test_what_cannot_be_played_is_refused_with_a_reason(data: bytes, said: str) -> None:
    with pytest.raises(UnknownSound) as error:
        SoundReader(24_000).add(data)
    assert said in str(error.value)


def test_a_rate_that_is_not_resampled_is_refused() -> None:
    with pytest.raises(UnknownSound, match="sound of 0 Hz"):
        SoundReader(0)


def test_volume_lowers_it() -> None:
    loud = np.full(4800, 10_000, "<i2").tobytes()
    assert np.abs(read(SoundReader(48_000, 25), loud, 960)[200:-200] - 2500).max() <= 2
    assert not read(SoundReader(48_000, 0), loud, 960).any()


@given(st.binary(max_size=200), st.integers(1, 50))
@settings(max_examples=200, deadline=None)
def test_whatever_comes_is_read_or_refused(data: bytes, piece: int) -> None:
    for head in (b"", b"RIFF", wav()[:36], wav()[:44]):
        with suppress(UnknownSound):
            read(SoundReader(24_000), head + data, piece)
