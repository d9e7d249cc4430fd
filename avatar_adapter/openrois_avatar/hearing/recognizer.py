"""What a speech recogniser is to the avatar: the seam for better ones than the offline one."""

from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from openrois_avatar.backends import Backend

__all__ = ["RECOGNIZERS", "Expectation", "RecognizerFailed", "SpeechRecognizer", "Transcriber"]

RECOGNIZERS: Final = "openrois.speech_recognizers"
"""The group of entry points; each is called without arguments and returns a `SpeechRecognizer`."""


class RecognizerFailed(Exception):
    """A transcriber is of no more use; the text says why. Another can be opened."""


@dataclass(frozen=True, slots=True)
class Expectation:
    """What speech is expected, as an application sets it.

    `languages` are ISO 639-1 codes. `grammar` is the name of a grammar (`default`: anything) or the text of one in
    JSGF, and `rule` its rule to begin with (`default`: its first public one).
    """

    languages: tuple[str, ...]
    grammar: str = "default"
    rule: str = "default"


class Transcriber(Protocol):
    """A recogniser at work: one utterance after the other, each call awaited before the next.

    Every call raises `RecognizerFailed` where it fails, and within a bounded time.
    """

    async def begin(self, expected: Expectation) -> None:
        """Begin an utterance, of which something is expected that the recogniser does not refuse."""
        ...

    async def hear(self, samples: NDArray[np.int16]) -> str:
        """Take the next part of the utterance, 16 kHz mono of shape (n,); returns what is understood so far."""
        ...

    async def end(self) -> tuple[str, ...]:
        """End it; returns what may have been said, the likeliest first, or nothing if it was no such speech."""
        ...


class SpeechRecognizer(Backend, Protocol):
    """Writes down what is said."""

    @property
    def languages(self) -> tuple[str, ...]:
        """The ISO 639-1 codes of what it recognises, its own choice first."""
        ...

    def refusal(self, expected: Expectation) -> str:
        """Why this cannot be expected, in a sentence for a person; empty if it can. It must not block for long."""
        ...

    def open(self) -> AbstractAsyncContextManager[Transcriber]:
        """Be ready to recognise for as long as the context lasts; raises `RecognizerFailed`."""
        ...
