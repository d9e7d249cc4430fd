import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray
from openrois_streaming.source.downsample import DOWNSAMPLED_RATES, SPEECH_RATE, Downsampler


def tone(hertz: float, seconds: float = 0.5, amplitude: float = 10_000.0) -> NDArray[np.int16]:
    wave = amplitude * np.sin(2 * np.pi * hertz * np.arange(round(seconds * 48_000)) / 48_000)
    return np.rint(np.column_stack([wave, wave])).astype(np.int16)


def level(samples: NDArray[np.int16]) -> float:
    return float(np.sqrt(np.mean(samples[200:-200].astype(float) ** 2)))


@pytest.mark.parametrize("hertz", [100, 1000, 3000, 6000])
def test_frequencies_of_speech_pass(hertz: float) -> None:
    lower = Downsampler().add(tone(hertz))
    assert abs(len(lower) - 0.5 * SPEECH_RATE) < 30
    assert level(lower) == pytest.approx(10_000 / 2**0.5, rel=0.02)
    spectrum = np.abs(np.fft.rfft(lower))
    assert spectrum.argmax() * SPEECH_RATE / len(lower) == pytest.approx(hertz, abs=5)


@pytest.mark.parametrize("hertz", [9_000, 12_000, 15_900, 20_000])
def test_high_frequencies_do_not_alias(hertz: float) -> None:
    assert level(Downsampler().add(tone(hertz))) < 30


@pytest.mark.parametrize("rate", DOWNSAMPLED_RATES)
def test_each_rate_keeps_what_it_can_carry_and_nothing_else(rate: int) -> None:
    lower = Downsampler(rate).add(tone(rate / 6))
    assert abs(len(lower) - 0.5 * rate) < 30
    assert level(lower) == pytest.approx(10_000 / 2**0.5, rel=0.02)
    if rate < 48_000:
        assert level(Downsampler(rate).add(tone(rate * 0.6))) < 30


def test_two_channels_are_one() -> None:
    left = tone(500)
    left[:, 1] = 0
    assert level(Downsampler().add(left)) == pytest.approx(5_000 / 2**0.5, rel=0.02)
    assert (Downsampler().add(tone(500)[:, :1]) == Downsampler().add(tone(500))).all()


@given(arrays.arrays(np.int16, st.tuples(st.integers(0, 700), st.just(2))), st.lists(st.integers(0, 700), max_size=5))
def test_blocks_make_no_difference(samples: NDArray[np.int16], cuts: list[int]) -> None:
    whole, parts = Downsampler(), Downsampler()
    pieces = [parts.add(piece) for piece in np.split(samples, sorted(cuts))]
    assert (np.concatenate(pieces) == whole.add(samples)).all()
