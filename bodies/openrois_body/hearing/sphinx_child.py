"""The recogniser's process: the only module that loads PocketSphinx. Run as `python -m` with its name.

It reads requests from stdin and answers each on stdout (`openrois_body.processes.framing`), until stdin ends:

    {"do": "greet"}
        -> {}
    {"do": "begin", "grammar": text in JSGF, or null for open dictation}
        -> {}; an utterance that was not ended is forgotten
    {"do": "hear"} and s16 mono sound at 16 kHz
        -> {"partial": what is understood so far}
    {"do": "end", "most": number of candidates}
        -> {"candidates": [texts, the likeliest first], "score": of the first: acoustic, per 10 ms,
            "before": text that was the likeliest before the sound was heard as a whole; the first one in dictation}
    what cannot be done
        -> {"refused": reason}
"""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pocketsphinx import Decoder

from openrois_body.processes.framing import HEADER, FramingError, decode_body, decode_header, encode

_OPEN: Final = "_default"
_GRAMMAR: Final = "grammar"
_WHILE_HEARD: Final = "while it is heard"
"""The searches: open dictation, a grammar in the whole of an utterance, and one in its parts as they come."""
_THOROUGH: Final = 144_000
"""Bytes of sound, 4.5 s, up to which the lattice of a grammar with words for other speech is looked at: it takes longer
the longer that speech is, and no sentence is."""
_WORDS: Final = 8
"""Words up to which it is, likewise."""
_LOOKED_AT: Final = 20
"""Hypotheses of the lattice; many of them are the same words, pronounced in another way."""
_NICE: Final = 5
"""Pictures and voices go first: words may come a little later."""
_FAINT: Final = 30.0
"""Root mean square of the noise that is laid under the sound for a grammar, of speech of 2,000: the model knows no
digital silence, as browsers and synthetic voices have it."""
_LEAST: Final = -7_000_000.0
"""The value of a score that is too low for a floating-point number."""


class Ears:
    """The decoder, loaded once for this process."""

    def __init__(self) -> None:
        self._decoder = Decoder(samprate=16_000, loglevel="FATAL")
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
                found = self._decoder.hyp()
                return {"partial": found.hypstr if found else ""}
            case "end":
                return self._finish_utterance(int(request["most"]))
        raise ValueError(f"unknown request {request['do']!r}; expected greet, begin, hear or end")

    def _begin(self, grammar: str | None) -> dict[str, Any]:
        self._finish()
        if grammar is not None and grammar != self._grammar:
            # The first one looks at the lattice of all words in the end, the other one does not.
            for name, is_thorough in ((_GRAMMAR, True), (_WHILE_HEARD, False)):
                self._decoder.config["bestpath"] = is_thorough
                self._decoder.add_jsgf_string(name, grammar)
            self._grammar = grammar
        self._decoder.activate_search(_OPEN if grammar is None else _WHILE_HEARD)
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
        before = self._decoder.hyp()
        if self._heard:
            # Once more as a whole: its loudness and the colour of voice and room are known now, not those of the
            # utterance before. With a grammar that takes a tenth of its length.
            whole = b"".join(self._heard)
            is_short = len(whole) <= _THOROUGH and len(before.hypstr.split() if before else ()) <= _WORDS
            self._decoder.activate_search(_GRAMMAR if most > 1 or is_short else _WHILE_HEARD)
            self._decoder.start_utt()
            self._decoder.process_raw(whole, no_search=False, full_utt=True)
            self._decoder.end_utt()
        found = self._decoder.hyp()
        if not found or not found.hypstr:
            return {"candidates": [], "score": 0.0, "before": ""}
        score = self._score()
        further = itertools.islice(self._decoder.nbest(), _LOOKED_AT) if most > 1 else ()
        others = (each.hypstr for each in further if each)
        candidates = [each for each in dict.fromkeys((found.hypstr, *others)) if each]
        return {"candidates": candidates[:most], "score": score, "before": before.hypstr if before else ""}

    def _finish(self) -> None:
        if self._hearing:
            self._hearing = False
            self._decoder.end_utt()

    def _score(self) -> float:
        words = [each for each in self._decoder.seg() if each.word[:1] not in "<[+"]
        frames = max(1, int(sum(each.end_frame - each.start_frame + 1 for each in words)))
        scores = (self._log.log(each.ascore) if each.ascore > 0 else _LEAST for each in words)
        return float(sum(scores)) / frames


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
