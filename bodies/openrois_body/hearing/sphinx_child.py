"""The recogniser's process: the only module that loads PocketSphinx. Run as `python -m` with its name.

It reads requests from stdin and answers each on stdout (`openrois_body.processes.framing`), until stdin ends:

    {"do": "greet"}
        -> {}
    {"do": "begin", "grammar": text in JSGF, or null for open dictation}
        -> {}; an utterance that was not ended is forgotten
    {"do": "hear"} and s16 mono sound at 16 kHz
        -> {"partial": what is understood so far}
    {"do": "end", "most": number of candidates}
        -> {"candidates": [texts, the likeliest first; of a grammar one at most]}; with a grammar also
           {"score", "worse", "outside": of `openrois_body.hearing.likeness.Likeness`}
    what cannot be done
        -> {"refused": reason}
"""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pocketsphinx import Decoder

from openrois_body.hearing.likeness import UNLIKE, Span, compare
from openrois_body.processes.framing import HEADER, FramingError, decode_body, decode_header, encode

_OPEN: Final = "_default"
_GRAMMAR: Final = "grammar"
_PHONES: Final = "phones"
"""The searches: open dictation, a grammar, and any sounds of speech in any order."""
_LOOKED_AT: Final = 20
"""Hypotheses of the lattice; many of them are the same words, pronounced in another way."""
_NICE: Final = 5
"""Pictures and voices go first: words may come a little later."""
_FAINT: Final = 30.0
"""Root mean square of the noise that is laid under the sound for a grammar, of speech of 2,000: the model knows no
digital silence, as browsers and synthetic voices have it."""
_NO_WORD: Final = "(NULL)"
"""Stands between words where a rule of a grammar ends."""
_SCALE: Final = 1024.0
"""Acoustic scores of a grammar and of sounds come divided by this."""


class Ears:
    """The decoder, loaded once for this process."""

    def __init__(self) -> None:
        self._decoder = Decoder(samprate=16_000, loglevel="FATAL")
        # The lattice of all words is for dictation alone: of a grammar, beeps can make one that takes 9 s to look at.
        self._decoder.config["bestpath"] = False
        self._decoder.add_allphone_file(_PHONES, None)
        self._log = self._decoder.logmath
        self._grammar: str | None = None
        self._hearing = False
        self._heard: list[bytes] | None = None
        """The sound of the utterance where there is a grammar."""

    def answer_request(self, request: Mapping[str, Any], sound: bytes) -> dict[str, Any]:
        """Answer one request.

        Raises:
            ValueError, KeyError: it cannot be done.
        """
        match request["do"]:
            case "greet":
                return {}
            case "begin":
                return self._begin(request["grammar"])
            case "hear":
                if sound:
                    self._add(sound)
                return {"partial": self._text()}
            case "end":
                return self._finish_utterance(int(request["most"]))
        raise ValueError(f"unknown request {request['do']!r}; expected greet, begin, hear or end")

    def _begin(self, grammar: str | None) -> dict[str, Any]:
        self._finish()
        if grammar is not None and grammar != self._grammar:
            self._decoder.add_jsgf_string(_GRAMMAR, grammar)
            self._grammar = grammar
        self._decoder.activate_search(_OPEN if grammar is None else _GRAMMAR)
        self._decoder.start_utt()
        self._hearing = True
        self._heard = None if grammar is None else []
        return {}

    def _add(self, sound: bytes) -> None:
        if self._heard is not None:
            sound = _with_noise(sound, len(self._heard))
            self._heard.append(sound)
        self._decoder.process_raw(sound, no_search=False, full_utt=False)

    def _finish_utterance(self, most: int) -> dict[str, Any]:
        self._finish()
        if self._heard is not None:
            return self._finish_sentence(b"".join(self._heard))
        further = (each.hypstr for each in itertools.islice(self._decoder.nbest(), _LOOKED_AT) if each)
        candidates = [each for each in dict.fromkeys((self._text(), *further)) if each]
        return {"candidates": candidates[:most]}

    def _finish_sentence(self, sound: bytes) -> dict[str, Any]:
        """Hear the sound as a whole: its loudness and the colour of voice and room are known now, not those before.

        That is done twice, with the grammar and for the sounds of speech, and takes a twentieth of its length.
        """
        words = self._hear_whole(_GRAMMAR, sound) if sound else []
        text = self._text()
        likeness = compare(words, self._hear_whole(_PHONES, sound), np.frombuffer(sound, "<i2")) if text else UNLIKE
        return {"candidates": [text] if text else [], **asdict(likeness)}

    def _hear_whole(self, search: str, sound: bytes) -> list[Span]:
        """Hear the sound by a search, and return the words or sounds that it finds, without silence and noises."""
        self._decoder.activate_search(search)
        self._decoder.start_utt()
        self._decoder.process_raw(sound, no_search=False, full_utt=True)
        self._decoder.end_utt()
        parts = self._decoder.seg() if self._text() else None
        return [
            Span(each.start_frame, each.end_frame + 1, _SCALE * self._log.log(each.ascore), each.word[:1] not in "<[+")
            for each in parts or ()
            if each.word != _NO_WORD
        ]

    def _text(self) -> str:
        found = self._decoder.hyp()
        return found.hypstr if found else ""

    def _finish(self) -> None:
        if self._hearing:
            self._hearing = False
            self._decoder.end_utt()


def _with_noise(sound: bytes, number: int) -> bytes:
    """Return s16 sound with faint noise under it, the same again for the part of the same number."""
    samples: NDArray[np.int16] = np.frombuffer(sound, "<i2")
    noise = np.random.default_rng(number).normal(0.0, _FAINT, len(samples))
    return np.clip(np.rint(samples + noise), -32_768, 32_767).astype("<i2").tobytes()


def main() -> None:
    """Answer requests until stdin ends."""
    # The library may print to stdout, which is the conversation: give it stderr instead.
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    os.nice(_NICE)
    ears = Ears()
    try:
        while True:
            lengths = decode_header(_read(HEADER.size))
            request, sound = decode_body(_read(lengths.body)), _read(lengths.sound)
            try:
                answer = ears.answer_request(request, sound)
            except (ValueError, KeyError, TypeError, RuntimeError) as error:
                answer = {"refused": str(error)}
            replies.write(encode(answer))
            replies.flush()
    except (EOFError, BrokenPipeError):
        return
    except FramingError as error:
        raise SystemExit(str(error)) from error


def _read(size: int) -> bytes:
    data = sys.stdin.buffer.read(size)
    if len(data) < size:
        raise EOFError
    return data


if __name__ == "__main__":
    main()
