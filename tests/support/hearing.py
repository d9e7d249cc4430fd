"""Sounds for tests of hearing: synthetic voices, other sounds, and text spoken by flite."""

import shutil
import subprocess
import wave
from functools import cache
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

__all__ = ["RATE", "not_speech", "spoken", "stereo_48k", "voice"]

RATE = 16_000
Sound = NDArray[np.int16]
_FORMANTS = ((700, 1200, 2600), (300, 2200, 3000), (500, 900, 2500), (400, 1900, 2550), (350, 800, 2400))
"""Of five vowels, in Hz."""


def voice(seconds: float, pitch: float = 120.0, amplitude: float = 8000.0) -> Sound:
    """Return a babbling voice: a buzz of gliding pitch through formants that change vowels 5 times a second."""
    time = np.arange(round(seconds * RATE)) / RATE
    frequency = pitch * (1 + 0.12 * np.sin(2 * np.pi * 1.3 * time))
    phase = 2 * np.pi * np.cumsum(frequency) / RATE
    vowels = np.array([_FORMANTS[number % len(_FORMANTS)] for number in range(int(seconds * 5) + 2)])
    formants = np.array([np.interp(time * 5, np.arange(len(vowels)), each) for each in vowels.T])
    sound = np.zeros(len(time))
    for harmonic in range(1, 40):
        distance = (harmonic * frequency - formants) / 90
        sound += (1 / (1 + distance**2)).sum(axis=0) * np.sin(harmonic * phase) / harmonic**0.3
    syllables = 0.55 - 0.45 * np.cos(2 * np.pi * 5 * time)
    return np.asarray(np.rint(sound / np.abs(sound).max() * syllables * amplitude), np.int16)


@cache
def not_speech() -> dict[str, Sound]:
    """Three seconds each of what a microphone hears beside voices."""
    random = np.random.default_rng(1)
    count = 3 * RATE
    time = np.arange(count) / RATE
    notes = random.choice([262, 294, 330, 349, 392, 440, 494, 523], 16)
    pink = np.fft.rfft(random.normal(0, 1, count)) / np.sqrt(np.maximum(1, np.arange(count // 2 + 1)))
    beats = np.concatenate([_struck(60, 4000, 2, 20, 9000), random.normal(0, 5000, 4000) * _fading(4000, 30)] * 6)
    chords = np.concatenate([sum(_struck(note * step, 6000) for step in (1, 1.26, 1.5)) / 2 for note in notes[:8]])
    sounds = {
        "silence": np.zeros(count),
        "white noise": random.normal(0, 3000, count),
        "pink noise": np.fft.irfft(pink, count) * 300 * 100,
        "a tone of 440 Hz": 6000 * np.sin(2 * np.pi * 440 * time),
        "hum": 4000 * np.sign(np.sin(2 * np.pi * 110 * time)),
        "a siren": 6000 * np.sin(2 * np.pi * np.cumsum(300 + 250 * np.sin(np.pi * time)) / RATE),
        "a telephone": 4000 * (np.sin(2 * np.pi * 440 * time) + np.sin(2 * np.pi * 480 * time)) * (time % 1 < 0.5),
        "beeps": 6000 * np.sin(2 * np.pi * 880 * time) * (time * 4 % 1 < 0.4),
        "a melody": np.concatenate([_struck(note, 4000) for note in notes[:12]]),
        "chords": chords,
        "an organ": np.concatenate([_organ(note, 5000) for note in notes[:10]]),
        "drums": beats,
        "a band": np.resize(beats, count) * 0.5 + np.resize(chords, count) * 0.7,
        "slams": np.concatenate([random.normal(0, 9000, 16_000) * _fading(16_000, 13) for _ in range(3)]),
        "applause": random.normal(0, 1, count) * np.repeat(np.abs(random.normal(0, 3000, count // 800)), 800),
        "a motor": _motor(time) + random.normal(0, 500, count),
    }
    return {name: np.clip(sound, -32_768, 32_767).astype(np.int16) for name, sound in sounds.items()}


@cache
def spoken(text: str, speaker: str = "slt") -> Sound:
    """`text`, spoken by flite; the caller has to know that it is installed."""
    program = shutil.which("flite")
    assert program is not None
    said = subprocess.run(
        [program, "-voice", speaker, "-t", text, "-o", "/dev/stdout"], capture_output=True, check=True
    )
    with wave.open(BytesIO(said.stdout)) as sound:
        assert sound.getframerate() == RATE
        return np.frombuffer(sound.readframes(-1), np.int16)


def stereo_48k(mono: Sound) -> Sound:
    """16 kHz in one channel as 48 kHz in two, of shape (n, 2)."""
    size = len(mono)
    spectrum = np.zeros(3 * size // 2 + 1, complex)
    half = np.fft.rfft(mono)
    spectrum[: len(half)] = half
    finer = np.clip(np.rint(np.fft.irfft(spectrum, 3 * size) * 3), -32_768, 32_767).astype(np.int16)
    return np.column_stack([finer, finer])


def _fading(count: int, per_second: float) -> NDArray[np.float64]:
    return np.asarray(np.exp(-np.arange(count) / RATE * per_second))


def _struck(
    note: float, count: int, overtones: int = 6, per_second: float = 3, amplitude: float = 4000
) -> NDArray[np.float64]:
    """A string, or a drum, that is struck."""
    time = np.arange(count) / RATE
    parts = [
        amplitude / number * np.sin(2 * np.pi * note * number * time) * _fading(count, per_second * number)
        for number in range(1, overtones + 1)
    ]
    return np.asarray(np.sum(parts, axis=0))


def _organ(note: float, count: int) -> NDArray[np.float64]:
    time = np.arange(count) / RATE
    return np.asarray(
        np.sum([2500 / number * np.sin(2 * np.pi * note * number * time) for number in range(1, 8)], axis=0)
    )


def _motor(time: NDArray[np.float64]) -> NDArray[np.float64]:
    turns = np.cumsum(90 + 5 * np.sin(0.6 * np.pi * time)) / RATE
    return np.asarray(np.sum([3000 / number * np.sin(2 * np.pi * number * turns) for number in range(1, 20)], axis=0))
