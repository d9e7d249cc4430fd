"""The speech process: the only module that loads libespeak-ng. Run as `python -m openrois_body.speech.espeak_child`.

It reads requests from stdin and answers each on stdout (`framing`), until stdin ends:

    {"do": "voices"}
        -> {"languages": [BCP 47 tags], "voices": [names]}
    {"do": "speak", "text", "ssml": bool, "language", "voice": name or null, "volume": 0-100, "rate": words a minute}
        -> one answer for each piece of the speech, as it is made:
           {"words": [[ms, word, start]], "marks": [[ms, name]], "phonemes": [[ms, ipa]], "last": bool} and s16 mono
           sound at 48 kHz. `start` is the word's first character in the text or SSML that was asked for. What is told
           of a piece has its place in the sound of this piece, or behind it; a phoneme without a shape is no end of one
    {"do": "stop"}
        -> nothing; a text that is spoken is left, and answered as one that cannot be
    what cannot be done
        -> {"refused": reason}

libespeak-ng is GPL-3.0; this process is its own program, and what imports the library is this file alone.
"""

from __future__ import annotations

import ctypes
import os
import select
import sys
from collections.abc import Callable, Iterator, Mapping
from ctypes import POINTER, Structure, Union, c_char, c_char_p, c_int, c_short, c_size_t, c_ubyte, c_uint, c_void_p
from math import inf
from typing import Any, Final

import espeakng_loader
import numpy as np
from numpy.typing import NDArray

from openrois_body.processes.framing import HEADER, FramingError, decode_body, decode_header, encode
from openrois_body.speech.markup import MAX_SECONDS, MarkupError, Script, plain_text, safe_ssml
from openrois_body.speech.resample import SOURCE_RATE, TARGET_RATE, Resampler
from openrois_body.speech.visemes import is_sound
from openrois_body.speech.words import Place, WordFinder

_FIRST_MS: Final = 200
"""Least sound of the first piece of a speech."""
_PIECE_MS: Final = 500
"""Least sound of each other piece but the last."""
_SYNCHRONOUS: Final = 2
_BLOCK_MS: Final = 20
_PHONEME_EVENTS_IPA: Final = 1 | 2
_UTF8: Final = 1
_SSML: Final = 0x10
_BY_CHARACTER: Final = 1
_RATE: Final = 1
_VARIANT: Final = "!v/"
_LAST_EVENT, _WORD, _MARK, _PHONEME = 0, 1, 3, 7
_NOTHING: Final = np.zeros(0, np.int16)


class _EventId(Union):
    _fields_ = (("number", c_int), ("name", c_void_p), ("string", c_char * 8))


class _Event(Structure):
    _fields_ = (
        ("type", c_int),
        ("unique_identifier", c_uint),
        ("text_position", c_int),
        ("length", c_int),
        ("audio_position", c_int),
        ("sample", c_int),
        ("user_data", c_void_p),
        ("id", _EventId),
    )


class _Voice(Structure):
    _fields_ = (
        ("name", c_char_p),
        ("languages", c_void_p),
        ("identifier", c_char_p),
        ("gender", c_ubyte),
        ("age", c_ubyte),
        ("variant", c_ubyte),
        ("reserved", c_ubyte),
        ("score", c_int),
        ("spare", c_void_p),
    )


_OnSound = ctypes.CFUNCTYPE(c_int, POINTER(c_short), c_int, POINTER(_Event))
_OnUri = ctypes.CFUNCTYPE(c_int, c_int, c_char_p, c_char_p)


Send = Callable[[bytes], None]
"""Writes an answer."""


class Refused(Exception):
    """A refused request; the text says why."""


class Espeak:
    """The library, initialised once for this process.

    Args:
        is_left: tells whether the text that is spoken is to be left.
    """

    def __init__(self, is_left: Callable[[], bool]) -> None:
        self._is_left = is_left
        self._library = library = ctypes.CDLL(espeakng_loader.get_library_path())
        library.espeak_ListVoices.restype = POINTER(POINTER(_Voice))
        library.espeak_Synth.argtypes = [
            *(c_char_p, c_size_t, c_uint, c_int, c_uint, c_uint, POINTER(c_uint), c_void_p)
        ]
        data = espeakng_loader.get_data_path().encode()
        rate = library.espeak_Initialize(_SYNCHRONOUS, _BLOCK_MS, data, _PHONEME_EVENTS_IPA)
        if rate != SOURCE_RATE:
            raise SystemExit(f"espeak-ng cannot be initialised with {data.decode()}: {rate}")
        # The library keeps no reference to the callbacks; they live as long as this object.
        self._on_sound = _OnSound(self._on_block)
        self._on_uri = _OnUri(lambda _kind, _uri, _base: 1)  # 1: do not play what the URI names
        library.espeak_SetSynthCallback(self._on_sound)
        library.espeak_SetUriCallback(self._on_uri)
        self._languages = dict(_by_language(self._list(None)))
        variant = _Voice(languages=ctypes.cast(c_char_p(b"variant"), c_void_p))
        self._voices = {identifier.removeprefix(_VARIANT) for identifier, _ in self._list(variant)}
        self._pieces: _Pieces | None = None

    def voices(self, _request: Mapping[str, Any], send: Send) -> None:
        """Answer the request `voices`."""
        send(encode({"languages": sorted(self._languages), "voices": sorted(self._voices)}))

    def speak(self, request: Mapping[str, Any], send: Send) -> None:
        """Answer the request `speak`."""
        ssml = bool(request["ssml"])
        script = (safe_ssml if ssml else plain_text)(str(request["text"]))
        self._select(str(request["language"]), request["voice"])
        self._library.espeak_SetParameter(_RATE, min(450, max(80, int(request["rate"]))), 0)
        pieces = self._pieces = _Pieces(script, min(100, max(0, int(request["volume"]))), send)
        encoded = script.spoken.encode() + b"\0"
        flags = _UTF8 | (_SSML if ssml else 0)
        status = self._library.espeak_Synth(encoded, len(encoded), 0, _BY_CHARACTER, 0, flags, None, None)
        if pieces.failure is not None:
            raise pieces.failure
        if status != 0:
            raise Refused(f"espeak-ng cannot speak this text (status {status}); try another text")
        pieces.finish()

    def _select(self, language: str, voice: object) -> None:
        identifier = self._languages.get(_known(language, self._languages))
        if identifier is None:
            raise Refused(f"the language {language!r} is not available; synthesizable_languages lists the languages")
        if voice is not None:
            if voice not in self._voices:
                raise Refused(f"the voice {voice!r} is not available; available_voices lists the voices")
            identifier = f"{identifier}+{voice}"
        self._library.espeak_SetVoiceByName(identifier.encode())

    def _on_block(self, sound: Any, count: int, events: Any) -> int:
        """Add the library's next block, as its callback; 1 stops the library."""
        pieces = self._pieces
        if pieces is None:
            return 1
        try:
            for number in range(4096):
                if events[number].type == _LAST_EVENT:
                    break
                pieces.note(events[number])
            pieces.add(np.frombuffer(ctypes.string_at(sound, 2 * count), np.int16) if sound and count > 0 else _NOTHING)
            if self._is_left():
                raise Refused("the text was left")
        except (OSError, Refused) as error:
            # An exception does not leave a callback: it is raised when the library has returned.
            pieces.failure = error
            return 1
        return 0

    def _list(self, kind: _Voice | None) -> Iterator[tuple[str, list[tuple[int, str]]]]:
        voices = self._library.espeak_ListVoices(None if kind is None else ctypes.byref(kind))
        number = 0
        while voices[number]:
            voice = voices[number].contents
            yield voice.identifier.decode(), list(_languages(voice.languages))
            number += 1


class _Pieces:
    """The speech of one text, sent in pieces. A piece ends where a phoneme begins, so that all before it is known.

    Args:
        script: that is spoken.
        volume: 0 to 100.
        send: writes an answer.
    """

    def __init__(self, script: Script, volume: int, send: Send) -> None:
        self.failure: Exception | None = None
        self._script = script
        self._loudness = np.float32(volume / 100)
        self._send = send
        self._finder = WordFinder(script.spoken, script.origins)
        self._resampler = Resampler(SOURCE_RATE)
        self._sound: list[NDArray[np.int16]] = []
        self._words: list[Place] = []
        self._marks: list[tuple[float, str]] = []
        self._phonemes: list[tuple[float, str]] = []
        self._made = 0
        """Samples that the library has made."""
        self._sent = 0
        """Samples that were sent."""
        self._sent_ms = 0.0
        self._least_ms = _FIRST_MS

    def note(self, event: _Event) -> None:
        """Note an event of the library."""
        offset = round(event.sample * 1000 / SOURCE_RATE, 1)
        if event.type == _WORD:
            self._words += self._finder.add([Place(offset, event.text_position - 1, event.length)])
        elif event.type == _MARK:
            self._marks.append((offset, self._script.marks[int(ctypes.string_at(event.id.name))]))
        elif event.type == _PHONEME:
            self._phonemes.append((offset, event.id.string.decode(errors="ignore")))

    def add(self, sound: NDArray[np.int16]) -> None:
        """Add the library's next sound, whose events were noted, and send what is complete.

        Raises:
            Refused: the speech is too long.
            OSError: there is no reader any more.
        """
        self._made += len(sound)
        if self._made > SOURCE_RATE * MAX_SECONDS:
            raise Refused(f"the speech would be longer than {MAX_SECONDS} seconds; split the text")
        self._sound.append(self._resampler.add(sound))
        until = max((at for at, ipa in self._phonemes if at <= self._finder.pending_ms and is_sound(ipa)), default=0.0)
        if until - self._sent_ms >= self._least_ms:
            self._put(until, last=False)
            self._sent_ms, self._least_ms = until, _PIECE_MS

    def finish(self) -> None:
        """Send the rest."""
        self._sound.append(self._resampler.finish())
        self._words += self._finder.find_last()
        self._put(inf, last=True)

    def _put(self, until_ms: float, *, last: bool) -> None:
        """Send what there is until a moment, with the phoneme that begins then."""
        sound = np.concatenate(self._sound)
        count = len(sound) if last else round(until_ms * TARGET_RATE / 1000) - self._sent
        # The sound of the resampler comes a little later than the library's.
        sound, self._sound = sound[:count], [sound[count:]]
        self._sent += len(sound)
        told = {
            "words": [
                (at, self._script.source[start : start + length], start)
                for at, start, length in self._words
                if at < until_ms
            ],
            "marks": [mark for mark in self._marks if mark[0] < until_ms],
            "phonemes": [phoneme for phoneme in self._phonemes if phoneme[0] <= until_ms],
            "last": last,
        }
        self._words = [word for word in self._words if word.offset_ms >= until_ms]
        self._marks = [mark for mark in self._marks if mark[0] >= until_ms]
        self._phonemes = [phoneme for phoneme in self._phonemes if phoneme[0] > until_ms]
        self._send(encode(told, np.rint(sound * self._loudness).astype("<i2").tobytes()))


def _languages(place: int) -> Iterator[tuple[int, str]]:
    """Return the languages of a voice: a byte of priority (low is first) and a name each, closed by a priority of 0."""
    while (priority := ctypes.string_at(place, 1)[0]) != 0:
        name = ctypes.string_at(place + 1)
        yield priority, name.decode().lower()
        place += len(name) + 2


def _by_language(voices: Iterator[tuple[str, list[tuple[int, str]]]]) -> Iterator[tuple[str, str]]:
    """Return the voices of each language, the best one last so that it wins in a dict."""
    offers = [(priority, name, identifier) for identifier, languages in voices for priority, name in languages]
    for _, name, identifier in sorted(offers, key=lambda offer: -offer[0]):
        yield name, identifier


def _known(language: str, languages: Mapping[str, str]) -> str:
    """Return the tag, or its longest available prefix: `de-AT` is spoken as `de`."""
    tag = language.lower().replace("_", "-")
    while tag not in languages and "-" in tag:
        tag = tag.rpartition("-")[0]
    return tag


def answer(espeak: Espeak, request: Mapping[str, Any], send: Send) -> None:
    """Answer one request; a wrong request is refused."""
    doing: Mapping[str, Callable[[Mapping[str, Any], Send], None]]
    doing = {"voices": espeak.voices, "speak": espeak.speak, "stop": lambda _request, _send: None}
    try:
        doing[request["do"]](request, send)
    except (Refused, MarkupError) as error:
        send(encode({"refused": str(error)}))
    except (KeyError, TypeError, ValueError) as error:
        send(encode({"refused": f"a malformed request: {error!r}"}))


def _read(stream: Any, size: int) -> bytes:
    data = b""
    while len(data) < size:
        part = stream.read(size - len(data))
        if not part:
            raise EOFError
        data += part
    return data


def main() -> None:
    """Answer requests until stdin ends."""
    # The library may print to stdout, which carries the answers: give it stderr instead.
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    # Not buffered: what has come is seen by select.
    requests = os.fdopen(os.dup(sys.stdin.fileno()), "rb", buffering=0)
    espeak = Espeak(lambda: bool(select.select([requests], [], [], 0)[0]))

    def send(message: bytes) -> None:
        replies.write(message)
        replies.flush()

    try:
        while True:
            lengths = decode_header(_read(requests, HEADER.size))
            request = decode_body(_read(requests, lengths.body))
            answer(espeak, request, send)
    except (EOFError, BrokenPipeError):
        return
    except FramingError as error:
        raise SystemExit(str(error)) from error


if __name__ == "__main__":
    main()
