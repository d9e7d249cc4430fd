"""The offline recogniser, with speech that flite makes, and with a process that fails."""

import asyncio
import importlib.util
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.hearing import sphinx as module
from openrois_body.hearing.jsgf import chosen_grammar
from openrois_body.hearing.recognizer import OTHER_SPEECH, Expectation, RecognizerFailed, Transcriber
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.processes.child import Output

from tests.support.hearing import not_speech, spoken, voice
from tests.support.streaming import settle

pytestmark = pytest.mark.extra(name="hearing")

HEAD = "#JSGF V1.0;\ngrammar robot;\n"
COMMANDS = Expectation(
    ("en",),
    f"{HEAD}public <command> = go to the (window | door) | turn (left | right) [and wait] | <greeting>;\n"
    "public <stop> = stop;\npublic <greeting> = wave to the people;\n",
)
DICTATION = Expectation(("en",))


async def understood(transcriber: Transcriber, sound: NDArray[np.int16], expected: Expectation) -> tuple[str, ...]:
    await transcriber.begin(expected)
    for start in range(0, len(sound), 4000):
        await transcriber.hear(sound[start : start + 4000])
    return await transcriber.finish(lambda _: None)


class TestExpectations:
    @pytest.mark.parametrize("rule", ["default", "", "command", "stop", "<Stop>"])
    def test_a_rule_of_a_grammar(self, pocketsphinx: None, rule: str) -> None:
        assert Sphinx().refusal(Expectation(("en",), COMMANDS.grammar, rule)) == ""

    @pytest.mark.parametrize("grammar", ["", "default"])
    def test_open_dictation(self, grammar: str) -> None:
        assert Sphinx().refusal(Expectation(("en",), grammar)) == ""

    @pytest.mark.parametrize(
        ("grammar", "rule", "said"),
        [
            ("default", "stop", "its only rule is `default`"),
            ("stop", "default", "`default` or a text in JSGF"),
            (COMMANDS.grammar, "go", "no public rule 'go'; it has command, stop, greeting"),
            (COMMANDS.grammar + " " * 20_000, "default", "at most 16384 are allowed"),
            (f"{HEAD}public <a> = (stop;", "default", "is expected"),
            (f"{HEAD}public <a> = stop the zorgon of qwrtz;", "default", "does not have qwrtz, zorgon"),
        ],
    )
    def test_unsupported_expectation_is_refused(self, pocketsphinx: None, grammar: str, rule: str, said: str) -> None:
        assert said in Sphinx().refusal(Expectation(("en",), grammar, rule))

    async def test_without_the_library_it_says_what_to_install(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
        sentence = "speech recognition is not installed: run `pip install 'openrois[hearing]'`"
        assert Sphinx().available() == (False, sentence)
        assert "does not have" in Sphinx().refusal(COMMANDS)
        with pytest.raises(RecognizerFailed, match="not installed"):
            async with Sphinx().open():
                pass


@pytest.mark.usefixtures("flite", "pocketsphinx")
class TestSpeech:
    async def test_only_sentences_of_the_grammar_are_recognised(self) -> None:
        assert Sphinx().available() == (True, "")
        async with Sphinx().open() as transcriber:
            for text in ("go to the window", "turn left", "turn right and wait", "wave to the people"):
                for speaker in ("slt", "rms"):
                    assert await understood(transcriber, spoken(text, speaker), COMMANDS) == (text,)
            stop = Expectation(("en",), COMMANDS.grammar, "stop")
            assert await understood(transcriber, spoken("stop"), stop) == ("stop",)
            for text in ("what time is it", "hello how are you today", "can you hear me"):
                assert await understood(transcriber, spoken(text), COMMANDS) == ()
            for name, sound in not_speech().items():
                assert await understood(transcriber, sound, COMMANDS) == (), name
            assert await understood(transcriber, np.zeros(0, np.int16), COMMANDS) == ()

    def test_no_sound_is_looked_at_more_than_three_times_with_a_grammar(self, monkeypatch: pytest.MonkeyPatch) -> None:
        # Beeps made a lattice of words that took 9 s to look at.
        from openrois_body.hearing.sphinx_child import Ears

        class Counting:
            def __init__(self, decoder: Any) -> None:
                self._decoder, self.samples, self.lattices = decoder, 0, 0

            def process_raw(self, sound: bytes, **how: bool) -> None:
                self.samples += len(sound) // 2
                self._decoder.process_raw(sound, **how)

            def nbest(self) -> Any:
                self.lattices += 1
                return self._decoder.nbest()

            def __getattr__(self, name: str) -> Any:
                return getattr(self._decoder, name)

        ears = Ears()
        counting = Counting(ears._decoder)
        monkeypatch.setattr(ears, "_decoder", counting)
        assert not counting.config["bestpath"]
        grammar, rule = chosen_grammar(f"{HEAD}public <a> = stop | (one | two | three)+;", "")
        assert grammar is not None
        for sound in (not_speech()["beeps"], spoken("one two three")):
            counting.samples = 0
            ears.answer_request({"do": "begin", "grammar": grammar.text(rule)}, b"")
            ears.answer_request({"do": "hear"}, sound.tobytes())
            ears.answer_request({"do": "end", "most": 5}, b"")
            assert len(sound) < counting.samples <= 3 * len(sound)
        assert counting.lattices == 0

    async def test_open_dictation_understands_something_and_guesses_while_the_words_come(self) -> None:
        async with Sphinx().open() as transcriber:
            candidates = await understood(transcriber, spoken("hello how are you today"), DICTATION)
            assert "hello how are you today" in candidates
            assert 1 < len(set(candidates)) == len(candidates) <= 5
            await transcriber.begin(COMMANDS)
            sound = spoken("go to the window")
            assert await transcriber.hear(sound[:10_000]) != ""
            # What was not ended is forgotten.
            assert await understood(transcriber, spoken("turn left"), COMMANDS) == ("turn left",)


SOUND = voice(0.2)


@pytest.fixture
def _fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CHILD", "tests.support.fake_recognizer")
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: object())
    monkeypatch.setattr(module, "ANSWER_TIMEOUT", 0.3)


def doing(word: str) -> Expectation:
    return Expectation(("en",), f"{HEAD}public <a> = stop | {word} it;")


@pytest.mark.usefixtures("_fake")
class TestFailures:
    async def test_sentence_outside_of_the_grammar_is_no_candidate(self) -> None:
        async with Sphinx().open() as transcriber:
            await transcriber.begin(doing("listen"))
            assert await transcriber.hear(SOUND) == str(len(SOUND))
            assert await transcriber.finish(lambda _: None) == ("stop", "stop")

    @pytest.mark.parametrize(
        ("rules", "heard"),
        [
            ("public <a> = stop | mumble;", ()),
            ("public <a> = stop | outside;", ()),
            # It has won against words for other speech: what counts is how much better sounds in any order are.
            ("public <a> = stop | mumble | (<other_speech>)+;", ("stop", "stop")),
            ("public <a> = stop | worse | (<other_speech>)+;", (OTHER_SPEECH,)),
            ("public <a> = stop | outside | (<other_speech>)+;", (OTHER_SPEECH,)),
            ("public <a> = go | (<other_speech>)+;", (OTHER_SPEECH,)),
            ("public <a> = stop | noise | (<other_speech>)+;", ()),
            ("public <a> = stop | silence | (<other_speech>)+;", ()),
        ],
    )
    async def test_a_sentence_that_is_unlike_the_sound_was_not_said(self, rules: str, heard: tuple[str, ...]) -> None:
        rules += "\n<other_speech> = back | babel;" if "<other_speech>" in rules else ""
        async with Sphinx().open() as transcriber:
            assert await understood(transcriber, SOUND, Expectation(("en",), f"{HEAD}{rules}")) == heard

    async def test_words_for_other_speech_are_no_guess(self) -> None:
        async with Sphinx().open() as transcriber:
            for sentence, guess in (("back off", "back"), ("stop", "")):
                rules = f"public <a> = {sentence} | (<other_speech>)+;\n<other_speech> = back | babel;"
                await transcriber.begin(Expectation(("en",), f"{HEAD}{rules}"))
                assert await transcriber.hear(SOUND) == guess

    @pytest.mark.parametrize(
        ("word", "said"), [("die", "has died: something broke"), ("babble", "has died"), ("hang", "did not answer")]
    )
    async def test_a_process_that_fails_is_noticed(self, word: str, said: str) -> None:
        async with Sphinx().open() as transcriber:
            with pytest.raises(RecognizerFailed, match=said):
                await understood(transcriber, SOUND, doing(word))

    async def test_last_output_of_the_process_is_waited_for(self, monkeypatch: pytest.MonkeyPatch) -> None:
        read = Output.read

        async def read_late(output: Output, stream: asyncio.StreamReader) -> None:
            late = asyncio.StreamReader()
            late.feed_data(await stream.read())
            late.feed_eof()
            await settle()
            await read(output, late)

        monkeypatch.setattr(Output, "read", read_late)
        async with Sphinx().open() as transcriber:
            with pytest.raises(RecognizerFailed, match="has died: something broke"):
                await understood(transcriber, SOUND, doing("die"))

    async def test_a_refusal_is_told(self) -> None:
        async with Sphinx().open() as transcriber:
            with pytest.raises(RecognizerFailed, match="refused: that is not for me"):
                await transcriber.begin(doing("refuse"))

    async def test_a_process_that_does_not_start_is_noticed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(module, "_CHILD", "tests.support.no_such_module")
        with pytest.raises(RecognizerFailed, match="has died"):
            async with Sphinx().open():
                pass

    async def test_leaving_ends_a_process_that_hangs(self) -> None:
        async with Sphinx().open() as transcriber:
            await transcriber.begin(doing("hang"))
            hearing = asyncio.ensure_future(transcriber.hear(SOUND))
            await asyncio.sleep(0)
            hearing.cancel()
