"""Speech as a stream over the data channel `speech`: frames of sound, and messages about it both ways. Pure.

A frame is binary, all integers big endian:

    0  utterance   uint32, the application's number for one speech
    4  sequence    uint32, 0 for the first frame of a speech, one more for each that follows
    8  sound       1 to 4,088 bytes: one packet of Opus, or samples of 16 bits (little endian, mono)

A message is a text, one JSON object with `event` and `utterance`. `begin`, `words` and `end` go over `speech`, in order
with the sound; `clear` goes over `control`, so that it overtakes the sound. What the body tells comes over `speech`.
"""

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias, get_args

from openrois_streaming.input.messages import InputError

__all__ = [
    "FRAME_HEAD",
    "RATES",
    "SPEECH_MESSAGE_LIMIT",
    "Begin",
    "Clear",
    "End",
    "Finished",
    "Frame",
    "Granted",
    "Refused",
    "SpeechFormat",
    "SpeechMessage",
    "SpeechTold",
    "Started",
    "Starved",
    "TimedWord",
    "Words",
    "is_clear",
    "pack_frame",
    "parse_frame",
    "read_clear",
    "read_speech",
    "read_told",
]

SPEECH_MESSAGE_LIMIT: Final = 4096
"""Bytes of a frame or message."""
FRAME_HEAD: Final = struct.Struct(">II")
RATES: Final = (16_000, 24_000, 48_000)
"""Samples a second."""
MAX_SPOKEN_TEXT: Final = 1_000
"""Characters of the text that a speech begins with."""
MAX_WORDS: Final = 200
"""Words, and marks, of one message."""
MAX_WORD: Final = 100
"""Characters of a word, or of the name of a mark."""
_GREATEST: Final = 2**32 - 1
_DAY_MS: Final = 86_400_000

SpeechFormat: TypeAlias = Literal["pcm16", "opus"]
"""Coding of the sound: samples, or one packet of Opus in each frame."""
_FORMATS: Final[tuple[SpeechFormat, ...]] = get_args(SpeechFormat)


@dataclass(frozen=True, slots=True)
class Frame:
    """Sound of a speech."""

    utterance: int
    sequence: int
    sound: bytes


def pack_frame(frame: Frame) -> bytes:
    """Return the bytes of a frame."""
    return FRAME_HEAD.pack(frame.utterance, frame.sequence) + frame.sound


def parse_frame(data: bytes) -> Frame:
    """Read a frame.

    Raises:
        InputError: it is too short or too long.
    """
    if not FRAME_HEAD.size < len(data) <= SPEECH_MESSAGE_LIMIT:
        raise InputError(f"a frame has {FRAME_HEAD.size + 1} to {SPEECH_MESSAGE_LIMIT} bytes, not {len(data)}")
    utterance, sequence = FRAME_HEAD.unpack_from(data)
    return Frame(utterance, sequence, data[FRAME_HEAD.size :])


@dataclass(frozen=True, slots=True)
class TimedWord:
    """A word, or the name of a mark, and when it begins: milliseconds from the first sample of the speech."""

    text: str
    start_ms: int


@dataclass(frozen=True, slots=True)
class Begin:
    """A speech begins.

    Attributes:
        utterance: number of the speech, greater than that of any before it.
        format: coding of its sound.
        rate: of its samples, in Hz; with Opus that in which credits are counted.
        text: what will be said, for captions; empty if that is not known.
    """

    utterance: int
    format: SpeechFormat
    rate: int
    text: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        members = {"event": "begin", "utterance": self.utterance, "format": self.format, "rate": self.rate}
        return {**members, "text": self.text} if self.text else members


@dataclass(frozen=True, slots=True)
class Words:
    """When words of a speech begin, and marks."""

    utterance: int
    words: tuple[TimedWord, ...] = ()
    marks: tuple[TimedWord, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        lists = {"words": self.words, "marks": self.marks}
        members = {name: [[each.text, each.start_ms] for each in items] for name, items in lists.items() if items}
        return {"event": "words", "utterance": self.utterance, **members}


@dataclass(frozen=True, slots=True)
class End:
    """All sound of a speech has been sent."""

    utterance: int

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"event": "end", "utterance": self.utterance}


@dataclass(frozen=True, slots=True)
class Clear:
    """A speech falls silent at once; what of it is still on its way is dropped."""

    utterance: int

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"event": "clear", "utterance": self.utterance}


SpeechMessage: TypeAlias = Begin | Words | End


@dataclass(frozen=True, slots=True)
class Started:
    """The viewers hear the first sound; `speech_id` names the speech in the events of SpeechProgress."""

    utterance: int
    speech_id: str

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"event": "started", "utterance": self.utterance, "speech_id": self.speech_id}


@dataclass(frozen=True, slots=True)
class Granted:
    """So many samples may be sent in all, of which so many have been played."""

    utterance: int
    samples: int
    played: int

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"event": "credit", "utterance": self.utterance, "samples": self.samples, "played": self.played}


@dataclass(frozen=True, slots=True)
class Starved:
    """All that came was played, `position` milliseconds, and there is silence until more comes."""

    utterance: int
    position: int

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"event": "starved", "utterance": self.utterance, "position": self.position}


@dataclass(frozen=True, slots=True)
class Finished:
    """The speech is over after `position` milliseconds of it were heard; `reason` says why it was interrupted."""

    utterance: int
    position: int
    reason: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        members = {"event": "finished", "utterance": self.utterance, "position": self.position}
        return {**members, "reason": self.reason} if self.reason else members


@dataclass(frozen=True, slots=True)
class Refused:
    """Nothing is heard of a speech; what comes of it is dropped."""

    utterance: int
    reason: str

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"event": "refused", "utterance": self.utterance, "reason": self.reason}


SpeechTold: TypeAlias = Started | Granted | Starved | Finished | Refused
"""A message of the body."""


def read_speech(text: str) -> SpeechMessage:
    """Read a message of an application on the channel `speech`.

    Raises:
        InputError: it is not a valid message; the text names the wrong member.
    """
    body = _object(text)
    utterance = _integer(body, "utterance", _GREATEST)
    match body.get("event"):
        case "begin":
            rate = body.get("rate")
            if rate not in RATES or isinstance(rate, float):
                raise InputError(f"rate: must be one of {', '.join(map(str, RATES))}")
            return Begin(
                utterance, _format(body.get("format")), rate, _string(body.get("text", ""), "text", MAX_SPOKEN_TEXT)
            )
        case "words":
            return Words(utterance, _timed(body, "words"), _timed(body, "marks"))
        case "end":
            return End(utterance)
    raise InputError("event: must be begin, words or end")


def is_clear(text: str) -> bool:
    """Tell whether a message of the channel `control` is about speech, and not about keys and the like."""
    return '"clear"' in text


def read_clear(text: str) -> Clear:
    """Read a message of an application on the channel `control` for which `is_clear` is true.

    Raises:
        InputError: it is not a valid message; the text names the wrong member.
    """
    body = _object(text)
    if body.get("event") != "clear":
        raise InputError("event: must be clear")
    return Clear(_integer(body, "utterance", _GREATEST))


def read_told(text: str) -> SpeechTold | None:
    """Read a message of the body on the channel `speech`; None for one of a kind that is not known.

    Raises:
        InputError: it is not a valid message; the text names the wrong member.
    """
    body = _object(text)
    utterance = _integer(body, "utterance", _GREATEST)
    match body.get("event"):
        case "started":
            return Started(utterance, _string(body.get("speech_id"), "speech_id", MAX_WORD))
        case "credit":
            return Granted(utterance, _integer(body, "samples", 2**53), _integer(body, "played", 2**53))
        case "starved":
            return Starved(utterance, _integer(body, "position", 2**53))
        case "finished":
            reason = _string(body.get("reason", ""), "reason", SPEECH_MESSAGE_LIMIT)
            return Finished(utterance, _integer(body, "position", 2**53), reason)
        case "refused":
            return Refused(utterance, _string(body.get("reason"), "reason", SPEECH_MESSAGE_LIMIT))
    return None


def _object(text: str) -> Mapping[str, Any]:
    # A text has at least as many bytes as characters.
    if len(text) > SPEECH_MESSAGE_LIMIT or len(text.encode("utf-8", "surrogatepass")) > SPEECH_MESSAGE_LIMIT:
        raise InputError(f"the message has more than the {SPEECH_MESSAGE_LIMIT} bytes allowed")
    try:
        body = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("the message is not JSON: send one JSON object") from error
    if not isinstance(body, dict):
        raise InputError("the message is not a JSON object")
    return body


def _format(value: Any) -> SpeechFormat:
    for each in _FORMATS:
        if value == each:
            return each
    raise InputError(f"format: must be {' or '.join(_FORMATS)}")


def _integer(body: Mapping[str, Any], name: str, greatest: int) -> int:
    value = body.get(name)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= greatest:
        raise InputError(f"{name}: must be an integer from 0 to {greatest}")
    return value


def _string(value: Any, name: str, longest: int) -> str:
    if not isinstance(value, str) or len(value) > longest:
        raise InputError(f"{name}: must be a string of at most {longest} characters")
    return value


def _timed(body: Mapping[str, Any], name: str) -> tuple[TimedWord, ...]:
    items = body.get(name, [])
    if not isinstance(items, list) or len(items) > MAX_WORDS:
        raise InputError(f"{name}: must be an array of at most {MAX_WORDS} items")
    return tuple(_timed_word(item, name) for item in items)


def _timed_word(item: Any, name: str) -> TimedWord:
    if not isinstance(item, list) or len(item) != 2:
        raise InputError(f"{name}: each must be an array of a text and the milliseconds of its beginning")
    text = _string(item[0], name, MAX_WORD)
    if not text:
        raise InputError(f"{name}: a text must not be empty")
    return TimedWord(text, _integer({name: item[1]}, name, _DAY_MS))
