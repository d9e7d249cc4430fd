"""The contract of speech synthesizers: a text becomes sound piece by piece, and is played while it is made."""

from __future__ import annotations

from collections.abc import AsyncIterable, AsyncIterator, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Final, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.messages import Viseme
from openrois_body.services.address import ServiceAddress
from openrois_body.sound.engine_sound import SEAM

__all__ = [
    "DEFAULT_SYNTHESIZER",
    "SYNTHESIZERS",
    "NamedMark",
    "Speech",
    "SpeechChunk",
    "SpeechRefused",
    "SpeechRequest",
    "SpeechSynthesizer",
    "SpeechUnavailable",
    "VoiceSettings",
    "Word",
    "collect_speech",
]

SYNTHESIZERS: Final = "openrois.speech_synthesizers"
"""The group of entry points; each is called with `VoiceSettings` and returns a `SpeechSynthesizer`."""
DEFAULT_SYNTHESIZER: Final = "espeak"


class SpeechUnavailable(Exception):
    """Speech synthesis is not available now; the text says why, and what to install if something is missing."""


class SpeechRefused(ValueError):
    """A refused text: an unknown language or voice, malformed SSML, too long; the text says which."""


class Word(NamedTuple):
    """A word: when it begins, its text, and the position of its first character in the whole text."""

    offset_ms: float
    text: str
    position: int


class NamedMark(NamedTuple):
    """A mark of SSML, and when it is reached."""

    offset_ms: float
    name: str


@dataclass(frozen=True, slots=True)
class VoiceSettings:
    """What the options of the command line say of the voice; a synthesizer takes what it needs of them.

    Attributes:
        url: of the server that speaks; None: none was named.
        model: that speaks there; empty: the synthesizer's own choice.
        names: the voices to choose from, the first one by default; empty: the synthesizer's own.
        key_file: holds the key for the server.
        file: of the voice, on this machine.
        clock: the media clock.
    """

    url: ServiceAddress | None = None
    model: str = ""
    names: tuple[str, ...] = ()
    key_file: Path | None = None
    file: Path | None = None
    clock: MediaClock = field(default_factory=SystemClock, compare=False)


@dataclass(frozen=True, slots=True)
class SpeechRequest:
    """A text to be spoken.

    Attributes:
        text: at most 4,000 characters; an SSML document or a fragment of one if `ssml`.
        ssml: whether `text` is SSML.
        language: a BCP 47 tag.
        voice: one of the synthesizer's `voices()`; None for the language's own.
        volume: 0 (silent) to 100 (the loudest without distortion).
    """

    text: str
    ssml: bool = False
    language: str = "en"
    voice: str | None = None
    volume: int = 50


@dataclass(frozen=True, slots=True, eq=False)
class SpeechChunk:
    """The next piece of a speech, with what is known of it. Offsets count from the beginning of the speech.

    A word, mark or mouth shape comes with the piece that has its sound or with one before it, never later.

    Attributes:
        samples: mono at 48 kHz; may be empty.
        words: that begin, in order of time; none where the synthesizer does not tell them.
        visemes: likewise; those of a speech end with the mouth closed.
        marks: of SSML, likewise.
    """

    samples: NDArray[np.int16]
    words: tuple[Word, ...] = ()
    visemes: tuple[Viseme, ...] = ()
    marks: tuple[NamedMark, ...] = ()


class SpeechSynthesizer(Protocol):
    """Makes speech of texts, while its context lasts."""

    @property
    def tells_visemes(self) -> bool:
        """Whether the pieces have mouth shapes; where not, the mouth is read from the sound."""
        ...

    @property
    def destination(self) -> str:
        """Where texts are sent, as `https://host`; empty where they stay on this machine."""
        ...

    async def __aenter__(self) -> Self: ...

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def available(self) -> tuple[bool, str]:
        """Return whether it works here, and if not, what to do; fast, and without side effects."""
        ...

    async def languages(self) -> Sequence[str]:
        """Return the available languages, as BCP 47 tags; raises `SpeechUnavailable`."""
        ...

    async def voices(self) -> Sequence[str]:
        """Return the available voices; raises `SpeechUnavailable`."""
        ...

    def speak(self, request: SpeechRequest) -> AbstractAsyncContextManager[AsyncIterator[SpeechChunk]]:
        """Make speech of a text; its pieces come as they are made, and leaving the context ends that.

        Entering and every piece raise `SpeechRefused` and `SpeechUnavailable`, within a bounded time; a speech has at
        most ten minutes. Any number of texts may be spoken at a time, and may wait for each other.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Speech:
    """A text as sound and mouth shapes.

    `samples` is mono at 48 kHz; all else is in order of time, and `visemes` end with the mouth closed.
    """

    samples: NDArray[np.int16]
    words: tuple[Word, ...]
    visemes: tuple[Viseme, ...]
    marks: tuple[NamedMark, ...] = ()

    @property
    def duration(self) -> float:
        """Seconds."""
        return len(self.samples) / SAMPLE_RATE

    def after(self, samples: int) -> Speech:
        """Return the rest after so many samples; it fades in within 5 ms."""
        gone = samples * 1000 / SAMPLE_RATE
        left = self.samples[samples:].copy()
        seam = min(SEAM, len(left))
        left[:seam] = left[:seam] * (np.arange(seam) + 0.5) / SEAM
        shape = [viseme for viseme in self.visemes if viseme.offset_ms <= gone][-1:]
        return Speech(
            left,
            tuple(word._replace(offset_ms=word.offset_ms - gone) for word in self.words if word.offset_ms >= gone),
            (
                *(Viseme(0.0, viseme.shape, viseme.weight) for viseme in shape),
                *(
                    Viseme(viseme.offset_ms - gone, viseme.shape, viseme.weight)
                    for viseme in self.visemes
                    if viseme.offset_ms > gone
                ),
            ),
            tuple(mark._replace(offset_ms=mark.offset_ms - gone) for mark in self.marks if mark.offset_ms >= gone),
        )


async def collect_speech(chunks: AsyncIterable[SpeechChunk]) -> Speech:
    """Return the pieces of a speech as a whole, when the last one has come."""
    pieces = [chunk async for chunk in chunks]
    return Speech(
        np.concatenate([np.zeros(0, np.int16), *(piece.samples for piece in pieces)]),
        tuple(word for piece in pieces for word in piece.words),
        tuple(viseme for piece in pieces for viseme in piece.visemes),
        tuple(mark for piece in pieces for mark in piece.marks),
    )
