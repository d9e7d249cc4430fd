"""The interface of speech recognisers, for other backends than the offline one."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from openrois_body.backends import Backend
from openrois_body.services.address import ServiceAddress

__all__ = [
    "OTHER_SPEECH",
    "RECOGNIZERS",
    "EarsSettings",
    "Expectation",
    "RecognizerFailed",
    "SpeechRecognizer",
    "Transcriber",
]

RECOGNIZERS: Final = "openrois.speech_recognizers"
"""The group of entry points; each is called with `EarsSettings` and returns a `SpeechRecognizer`."""
OTHER_SPEECH: Final = ""
"""The only candidate of an utterance that was speech, but none of the grammar's sentences."""


class RecognizerFailed(Exception):
    """A transcriber has failed; the text says why. Another one can be opened."""


@dataclass(frozen=True, slots=True)
class EarsSettings:
    """What the options of the command line say of recognition; a recogniser takes what it needs of them.

    Attributes:
        url: of the server that recognises; None: none was named.
        model: that recognises there; empty: the recogniser's own choice.
        key_file: holds the key for the server.
    """

    url: ServiceAddress | None = None
    model: str = ""
    key_file: Path | None = None


@dataclass(frozen=True, slots=True)
class Expectation:
    """The expected languages and grammar, as an application sets them.

    `languages` are ISO 639-1 codes. `grammar` is the name of a grammar (`default`: anything) or the text of one in
    JSGF, and `rule` its rule to begin with (`default`: its first public one).
    """

    languages: tuple[str, ...]
    grammar: str = "default"
    rule: str = "default"


class Transcriber(Protocol):
    """A running recogniser: one utterance after the other, each call awaited before the next.

    Every call raises `RecognizerFailed` where it fails, and within a bounded time.
    """

    async def begin(self, expected: Expectation) -> None:
        """Begin an utterance, with an expectation that the recogniser does not refuse."""
        ...

    async def hear(self, samples: NDArray[np.int16]) -> str:
        """Add the next part of the utterance, 16 kHz mono of shape (n,), and return the partial result."""
        ...

    async def finish(self, guess: Callable[[str], None]) -> tuple[str, ...]:
        """End the utterance and return its candidates, the likeliest first; empty if it was no such speech.

        `OTHER_SPEECH` is the only one of speech that a grammar has no sentence for, where the recogniser can tell.

        Args:
            guess: called with each partial result that comes before.
        """
        ...


class SpeechRecognizer(Backend, Protocol):
    """A backend of speech recognition."""

    @property
    def destination(self) -> str:
        """Where sound is sent, as `https://host`; empty where it stays on this machine.

        One that has a destination gets the speech of those visitors alone who consent to that, too.
        """
        ...

    @property
    def languages(self) -> tuple[str, ...]:
        """The ISO 639-1 codes of what it recognises, its own choice first."""
        ...

    def refusal(self, expected: Expectation) -> str:
        """Return why this cannot be expected, in a sentence for a person; empty if it can. Must not block for long."""
        ...

    def open(self) -> AbstractAsyncContextManager[Transcriber]:
        """Run the recogniser for as long as the context lasts; raises `RecognizerFailed`."""
        ...
