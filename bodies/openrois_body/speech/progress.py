"""The steps of a speech that are told while it is heard. `at` is epoch seconds in all of them."""

from dataclasses import dataclass
from typing import TypeAlias

from openrois.types.codes import CompletedStatus
from openrois_body.speech.contract import Word

__all__ = ["MarkReached", "Progress", "SpeechBegan", "SpeechEnded", "SpeechStarved", "WordSpoken"]


@dataclass(frozen=True, slots=True)
class SpeechBegan:
    """The viewers hear the first sound of a text or of a stream."""

    speech_id: str
    text: str
    is_ssml: bool
    at: float


@dataclass(frozen=True, slots=True)
class WordSpoken:
    """The viewers hear a word that begins at character `position` of the text."""

    speech_id: str
    word: str
    position: int
    at: float


@dataclass(frozen=True, slots=True)
class MarkReached:
    """The viewers reach a mark of SSML."""

    speech_id: str
    mark: str
    at: float


@dataclass(frozen=True, slots=True)
class SpeechStarved:
    """All sound of a speech was played, `heard_ms` of it, and no more has come: the viewers hear silence."""

    speech_id: str
    heard_ms: int
    at: float


@dataclass(frozen=True, slots=True)
class SpeechEnded:
    """The speech has ended after `heard_ms` of its sound; `last` is the last word that was begun, if one was."""

    speech_id: str
    status: CompletedStatus
    reason: str
    last: Word | None
    at: float
    heard_ms: int


Progress: TypeAlias = SpeechBegan | WordSpoken | MarkReached | SpeechStarved | SpeechEnded
"""A step of a speech."""
