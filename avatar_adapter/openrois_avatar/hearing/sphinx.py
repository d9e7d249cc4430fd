"""Speech recognition without a network: asks a process that runs PocketSphinx, whose English model comes with it."""

import asyncio
import importlib.util
from asyncio.subprocess import Process
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import SystemClock

from openrois_avatar.child import Output, child_process, tell
from openrois_avatar.hearing.dictionary import has_word
from openrois_avatar.hearing.jsgf import Grammar, GrammarError, read_grammar
from openrois_avatar.hearing.recognizer import Expectation, RecognizerFailed, Transcriber
from openrois_avatar.speech.framing import HEADER, FramingError, decode_body, decode_header, encode

__all__ = ["ANSWER_TIMEOUT", "START_TIMEOUT", "Sphinx"]

START_TIMEOUT: Final = 20.0
"""Seconds for the process to load its models; it takes about one."""
ANSWER_TIMEOUT: Final = 10.0
"""Seconds for an answer; a second of open dictation takes about a quarter of one."""
MAX_GRAMMAR: Final = 16_384
"""Characters of a grammar."""
CANDIDATES: Final = 5
"""What may have been said, at most."""
_WORST: Final = -28_000.0
"""The acoustic score of a grammar's sentence from which on it was not said, in PocketSphinx's units per 10 ms.

Clean synthetic speech that was expected has -6,000 to -20,000, in noise down to -36,000; other speech mostly -30,000 to
-66,000.
"""
_CHILD: Final = "openrois_avatar.hearing.sphinx_child"
_LIBRARY: Final = "pocketsphinx"
_DICTIONARY: Final = "model/en-us/cmudict-en-us.dict"
_MISSING: Final = "speech recognition is not installed: run `pip install 'openrois[hearing]'`"


class Sphinx:
    """PocketSphinx with its model of American English; a `SpeechRecognizer`.

    Good at a grammar of some phrases, weak at open dictation: what it then makes of noise or of another language are
    English words, too.
    """

    languages = ("en",)

    def available(self) -> tuple[bool, str]:
        """Whether PocketSphinx is installed; if not, the sentence that says what to do."""
        found = importlib.util.find_spec(_LIBRARY) is not None
        return found, "" if found else _MISSING

    def refusal(self, expected: Expectation) -> str:
        """Why this cannot be expected; the words of a grammar are looked up in the dictionary."""
        try:
            grammar, rule = _chosen(expected)
        except GrammarError as error:
            return str(error)
        if grammar is None:
            return ""
        dictionary = _dictionary()
        unknown = sorted(word for word in grammar.words(rule) if not has_word(dictionary, word))
        return f"the dictionary does not have {', '.join(unknown[:10])}" if unknown else ""

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
    """Utterances, in the words of the process."""

    def __init__(self, conversation: "_Conversation") -> None:
        self._conversation = conversation
        self._grammar: Grammar | None = None
        self._rule = ""

    async def begin(self, expected: Expectation) -> None:
        self._grammar, self._rule = _chosen(expected)
        text = None if self._grammar is None else self._grammar.text(self._rule)
        await self._conversation.ask({"do": "begin", "grammar": text})

    async def hear(self, samples: NDArray[np.int16]) -> str:
        answer = await self._conversation.ask({"do": "hear"}, samples.astype("<i2").tobytes())
        return str(answer["partial"])

    async def end(self) -> tuple[str, ...]:
        answer = await self._conversation.ask({"do": "end"})
        candidates = tuple(str(each) for each in answer["candidates"])
        if self._grammar is not None:
            if answer["score"] < _WORST:
                return ()
            candidates = tuple(each for each in candidates if self._grammar.accepts(self._rule, each))
        return candidates[:CANDIDATES]


class _Conversation:
    """Questions to the process and its answers, one at a time."""

    def __init__(self, process: Process, output: Output) -> None:
        self._process = process
        self._output = output

    async def ask(self, request: dict[str, Any], sound: bytes = b"", timeout: float | None = None) -> dict[str, Any]:
        """Ask, and wait for the answer, `ANSWER_TIMEOUT` if nothing else is said.

        Raises:
            RecognizerFailed: there is none in time, it is none, or it says that the request cannot be done.
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
        await tell(self._process, message)
        lengths = decode_header(await stdout.readexactly(HEADER.size))
        return decode_body(await stdout.readexactly(lengths.body))


def _chosen(expected: Expectation) -> tuple[Grammar | None, str]:
    """The grammar and its rule, by name; None for open dictation.

    Raises:
        GrammarError: there is no such grammar or rule.
    """
    if expected.grammar in ("default", ""):
        if expected.rule not in ("default", ""):
            raise GrammarError("the grammar `default`, which is open dictation, has no rule but `default`")
        return None, ""
    if not expected.grammar.lstrip("\ufeff").startswith("#JSGF"):
        raise GrammarError("the grammar is `default` or a text in JSGF, which begins with `#JSGF V1.0;`")
    if len(expected.grammar) > MAX_GRAMMAR:
        raise GrammarError(f"a grammar has at most {MAX_GRAMMAR} characters")
    grammar = read_grammar(expected.grammar)
    return grammar, grammar.rule(expected.rule or "default")


def _dictionary() -> bytes:
    """The words that can be recognised; empty where nothing is installed."""
    found = importlib.util.find_spec(_LIBRARY)
    if found is None or found.origin is None:
        return b""
    return (Path(found.origin).parent / _DICTIONARY).read_bytes()
