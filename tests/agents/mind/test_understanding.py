"""What a recogniser with the mind's grammar understands; `openrois_bench.agents.phrases` has figures."""

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_agents.mind.expecting import expect_phrases
from openrois_agents.mind.phrases import Intent, Phrases, make_phrases
from openrois_agents.tools.names import Vocabulary
from openrois_body.hearing.recognizer import OTHER_SPEECH, Expectation, Transcriber
from openrois_body.hearing.sphinx import Sphinx

from openrois.client import BadParameter
from tests.support.hearing import spoken

pytestmark = [pytest.mark.extra(name="hearing"), pytest.mark.usefixtures("flite", "pocketsphinx")]

PHRASES = make_phrases(Vocabulary(gestures=("nod", "wave"), places=("coffee table", "plant", "sofa")))
SAID = (
    *("hello", "wave", "please wave", "go to the plant", "walk to the coffee table", "who are you", "come here"),
    *("what do you see", "what can you do", "stop talking", "thank you", "where are you", "what time is it"),
)
NOT_SAID = (
    "give it back to my brother",
    "nobody knows the answer",
    "i would like some coffee",
    "we were walking along the river",
    # They begin with a sentence.
    "hello how are you today my friend",
    "stop at the second lamp",
)


async def intents(transcriber: Transcriber, sound: NDArray[np.int16]) -> list[Intent]:
    # A body passes on what was before the speech, and the silence after which it has ended.
    sound = np.concatenate((np.zeros(4800, np.int16), sound, np.zeros(9600, np.int16)))
    await transcriber.begin(Expectation(("en",), PHRASES.grammar))
    for start in range(0, len(sound), 4000):
        await transcriber.hear(sound[start : start + 4000])
    candidates = await transcriber.finish(lambda _: None)
    # Words for other speech leave no recogniser.
    assert all(PHRASES.understand(each) for each in candidates if each != OTHER_SPEECH)
    return [meant for each in candidates if (meant := PHRASES.understand(each))][:1]


@pytest.mark.parametrize("speaker", [pytest.param("slt", marks=pytest.mark.long), "rms"])
async def test_phrases_of_a_voice_are_understood_and_other_speech_is_not(speaker: str) -> None:
    async with Sphinx().open() as transcriber:
        heard = {text: await intents(transcriber, spoken(text, speaker)) for text in SAID}
        missed = {text: meant for text, meant in heard.items() if meant != [PHRASES.understand(text)]}
        # One is too little like what the model has learnt: "who are you" or "thank you".
        assert len(missed) <= 1, missed
        for text in NOT_SAID:
            assert await intents(transcriber, spoken(text, speaker)) == [], text


async def test_names_that_the_dictionary_does_not_have_are_left_out() -> None:
    vocabulary = Vocabulary(
        gestures=("wave", "zorgon"), places=("plant", "qwrtz room", *(f"xq{c}z" for c in "abcdefghij"))
    )
    refused = 0

    async def set_grammar(text: str) -> None:
        nonlocal refused
        if reason := Sphinx().refusal(Expectation(("en",), text)):
            refused += 1
            raise BadParameter(reason)

    def make(unknown: object) -> Phrases:
        return make_phrases(vocabulary, unknown=unknown)  # type: ignore[arg-type]

    phrases = await expect_phrases(set_grammar, make)
    assert refused == 2
    assert phrases.left_out == ("zorgon", "qwrtz room", *(f"xq{c}z" for c in "abcdefghij"))
    assert phrases.understand("go to the plant")
