import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.speech.resample import RATES, SOURCE_RATE, TARGET_RATE, Resampler


def to_48k(samples: NDArray[np.int16], rate: int = SOURCE_RATE, piece: int = 1 << 20) -> NDArray[np.int16]:
    resampler = Resampler(rate)
    made = [resampler.add(samples[first : first + piece]) for first in range(0, len(samples), piece)]
    return np.concatenate([*made, resampler.finish()])


def tone(frequency: float, seconds: float = 1.0, rate: int = SOURCE_RATE) -> NDArray[np.int16]:
    moments = np.arange(round(seconds * rate)) / rate
    return np.round(20_000 * np.sin(2 * np.pi * frequency * moments)).astype(np.int16)


def spectrum(samples: NDArray[np.int16]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies, and the level of each in dB below a full tone."""
    inner = samples[4800:-4800].astype(float)
    window = np.kaiser(len(inner), 14)
    amplitudes = np.abs(np.fft.rfft(inner * window)) / (20_000 * window.sum() / 2)
    levels: NDArray[np.float64] = 20 * np.log10(amplitudes + 1e-12)
    return np.fft.rfftfreq(len(inner), 1 / TARGET_RATE).astype(np.float64), levels


@pytest.mark.parametrize("frequency", [100, 1_000, 5_000, 8_000, 10_000])
def test_a_tone_stays_a_tone(frequency: int) -> None:
    frequencies, levels = spectrum(to_48k(tone(frequency)))
    beside = np.abs(frequencies - frequency) > 50
    assert levels[~beside].max() == pytest.approx(0, abs=0.05)
    assert levels[beside].max() < -85


@pytest.mark.parametrize("rate", RATES)
def test_a_tone_of_any_rate_stays_a_tone(rate: int) -> None:
    sound = to_48k(tone(1_000, rate=rate), rate)
    assert len(sound) == TARGET_RATE
    frequencies, levels = spectrum(sound)
    beside = np.abs(frequencies - 1_000) > 50
    assert levels[~beside].max() == pytest.approx(0, abs=0.05)
    assert levels[beside].max() < -80


@pytest.mark.parametrize("piece", [1, 7, 64, 333, 5_000])
@pytest.mark.parametrize("rate", [SOURCE_RATE, 24_000, 48_000])
def test_pieces_of_any_length_become_the_same_sound(piece: int, rate: int) -> None:
    sound = tone(440, 0.1, rate)
    assert np.abs(to_48k(sound, rate, piece).astype(int) - to_48k(sound, rate)).max() <= 1


def test_sound_is_given_as_soon_as_it_can_be_computed() -> None:
    resampler = Resampler(24_000)
    early = resampler.add(tone(440, 0.1, 24_000))
    assert len(early) == 0.1 * TARGET_RATE - 64


@pytest.mark.parametrize(("samples", "expected"), [(0, 0), (1, 3), (147, 320), (148, 323), (22_050, 48_000)])
def test_the_length_fits_the_rates(samples: int, expected: int) -> None:
    assert len(to_48k(np.zeros(samples, np.int16))) == expected


def test_the_sound_is_not_shifted() -> None:
    click = np.zeros(2205, np.int16)
    click[1000] = 30_000
    assert abs(int(np.argmax(to_48k(click))) - 1000 * TARGET_RATE / SOURCE_RATE) < 1


def test_loud_sound_is_clipped_and_never_wraps() -> None:
    square = np.where(np.arange(2205) // 50 % 2, 32_767, -32_768).astype(np.int16)
    loud = to_48k(square)
    middle = loud[round(25 * TARGET_RATE / SOURCE_RATE)]
    assert middle < -30_000
    assert loud.max() == 32_767
    assert loud.min() == -32_768


@pytest.mark.parametrize("rate", [16_000, 24_000, 48_000])
@pytest.mark.parametrize("piece", [1, 31, 33, 320, 5_000])
def test_a_stream_does_not_drift_however_it_is_cut_up(rate: int, piece: int) -> None:
    click = np.zeros(4_000, np.int16)
    click[1_000] = 30_000
    found, factor = to_48k(click, rate, piece), TARGET_RATE // rate
    assert len(found) == factor * 4_000
    assert int(np.argmax(found)) == factor * 1_000
    assert np.array_equal(found, to_48k(click, rate))


@pytest.mark.parametrize(("rate", "late"), [(16_000, 32), (24_000, 32), (48_000, 0)])
def test_of_a_stream_no_more_is_kept_than_a_sample_depends_on(rate: int, late: int) -> None:
    resampler, made = Resampler(rate), 0
    for number in range(1, 20):
        made += len(resampler.add(np.ones(160, np.int16)))
        assert made == (number * 160 - late) * TARGET_RATE // rate


@pytest.mark.parametrize("rate", RATES)
def test_nothing_becomes_nothing(rate: int) -> None:
    assert len(Resampler(rate).finish()) == 0
