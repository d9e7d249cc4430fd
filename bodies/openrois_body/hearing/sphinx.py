"""Offline speech recognition by PocketSphinx in a process of its own, with its English model."""

import asyncio
import importlib.util
from asyncio.subprocess import Process
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import SystemClock

from openrois_body.hearing.dictionary import has_word
from openrois_body.hearing.jsgf import Grammar, GrammarError, chosen_grammar
from openrois_body.hearing.recognizer import (
    OTHER_SPEECH,
    EarsSettings,
    Expectation,
    RecognizerFailed,
    Transcriber,
)
from openrois_body.processes.child import Output, child_process, write_message
from openrois_body.processes.framing import HEADER, FramingError, decode_body, decode_header, encode

__all__ = ["ANSWER_TIMEOUT", "START_TIMEOUT", "Sphinx"]

START_TIMEOUT: Final = 20.0
"""Seconds for the process to load its models; it takes about one."""
ANSWER_TIMEOUT: Final = 10.0
"""Seconds for an answer; a second of open dictation takes about a quarter of one."""
CANDIDATES: Final = 5
"""Most candidates of an utterance."""
_WORST: Final = -28_000.0
"""The acoustic score of a grammar's sentence from which on it was not said, in PocketSphinx's units per 10 ms.

Synthetic speech that was expected has mostly -14,000 to -30,000, some of it less; other speech -30,000 to -66,000.
"""
_WORSE: Final = 2.2
"""What `Likeness.worse` of a sentence that has won against words for other speech must not exceed."""
_OUTSIDE: Final = 12
"""What `Likeness.outside` of a sentence must not exceed.

Both were chosen for a half of what four synthetic voices had said, with words for other speech: of 235 sentences that
had won rightly they keep 233, of 45 others 8.
"""
_NO_SPEECH: Final = 5.0
"""`Likeness.worse` of what is no speech either; that of other speech is up to 4."""
_CHILD: Final = "openrois_body.hearing.sphinx_child"
_LIBRARY: Final = "pocketsphinx"
_DICTIONARY: Final = "model/en-us/cmudict-en-us.dict"
_MISSING: Final = "speech recognition is not installed: run `pip install 'openrois[hearing]'`"


class Sphinx:
    """PocketSphinx with its model of American English; a `SpeechRecognizer`.

    Good at a grammar of some phrases, weak at open dictation: what it then makes of noise or of another language are
    English words, too.
    """

    languages = ("en",)
    destination = ""

    def __init__(self, _settings: EarsSettings | None = None) -> None:
        """It needs no settings: its model is a part of it."""

    def available(self) -> tuple[bool, str]:
        """Return whether PocketSphinx is installed; if not, the sentence that says what to do."""
        found = importlib.util.find_spec(_LIBRARY) is not None
        return found, "" if found else _MISSING

    def refusal(self, expected: Expectation) -> str:
        """Return why this cannot be expected; the words of a grammar are looked up in the dictionary."""
        try:
            grammar, rule = chosen_grammar(expected.grammar, expected.rule)
        except GrammarError as error:
            return str(error)
        if grammar is None:
            return ""
        dictionary = _dictionary()
        unknown = sorted(word for word in grammar.words(rule) if not has_word(dictionary, word))
        return f"the dictionary does not have {', '.join(unknown[:10])}; use other words" if unknown else ""

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Transcriber]:
        """Run the process for as long as the context lasts."""
        works, reason = self.available()
        if not works:
            raise RecognizerFailed(reason)
        output = Output("speech recognition", SystemClock())
        async with child_process(_CHILD, output=output, conversation=True) as process:
            conversation = _Conversation(process, output)
            await conversation.ask({"do": "greet"}, timeout=START_TIMEOUT)
            yield _Transcriber(conversation)


class _Transcriber:
    """A transcriber that asks the process."""

    def __init__(self, conversation: "_Conversation") -> None:
        self._conversation = conversation
        self._grammar: Grammar | None = None
        self._rule = ""

    async def begin(self, expected: Expectation) -> None:
        self._grammar, self._rule = chosen_grammar(expected.grammar, expected.rule)
        text = None if self._grammar is None else self._grammar.text(self._rule)
        await self._conversation.ask({"do": "begin", "grammar": text})

    async def hear(self, samples: NDArray[np.int16]) -> str:
        answer = await self._conversation.ask({"do": "hear"}, samples.astype("<i2").tobytes())
        text = str(answer["partial"])
        if self._grammar is None or not self._grammar.has_other_speech(self._rule):
            return text
        return text if self._grammar.begins(self._rule, text) else ""

    async def finish(self, _guess: Callable[[str], None]) -> tuple[str, ...]:
        answer = await self._conversation.ask({"do": "end", "most": CANDIDATES})
        candidates = tuple(str(each) for each in answer["candidates"])
        if self._grammar is None or not candidates:
            return candidates
        said = tuple(each for each in candidates if self._grammar.accepts(self._rule, each))
        has_others = self._grammar.has_other_speech(self._rule)
        is_like = answer["worse"] <= _WORSE if has_others else answer["score"] >= _WORST
        if said and is_like and answer["outside"] <= _OUTSIDE:
            return said
        return (OTHER_SPEECH,) if has_others and answer["worse"] < _NO_SPEECH else ()


class _Conversation:
    """Requests to the process and its answers, one at a time."""

    def __init__(self, process: Process, output: Output) -> None:
        self._process = process
        self._output = output

    async def ask(self, request: dict[str, Any], sound: bytes = b"", timeout: float | None = None) -> dict[str, Any]:
        """Send a request and return its answer, within `ANSWER_TIMEOUT` unless another time is given.

        Raises:
            RecognizerFailed: no answer in time, a malformed one, or a refusal.
        """
        timeout = ANSWER_TIMEOUT if timeout is None else timeout
        try:
            async with asyncio.timeout(timeout):
                answer = await self._exchange(encode(request, sound))
        except TimeoutError:
            raise RecognizerFailed(f"the speech recogniser did not answer within {timeout:g} seconds") from None
        except (EOFError, OSError, FramingError):
            await self._output.all_said()
            words = self._output.last_words
            raise RecognizerFailed(f"the speech recogniser has died: {words}".rstrip(" :")) from None
        if "refused" in answer:
            raise RecognizerFailed(f"the speech recogniser refused: {answer['refused']}")
        return answer

    async def _exchange(self, message: bytes) -> dict[str, Any]:
        stdout = self._process.stdout
        assert stdout is not None
        await write_message(self._process, message)
        lengths = decode_header(await stdout.readexactly(HEADER.size))
        return decode_body(await stdout.readexactly(lengths.body))


def _dictionary() -> bytes:
    """Return the pronouncing dictionary; empty where PocketSphinx is not installed."""
    found = importlib.util.find_spec(_LIBRARY)
    if found is None or found.origin is None:
        return b""
    return (Path(found.origin).parent / _DICTIONARY).read_bytes()
