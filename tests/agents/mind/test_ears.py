"""The ears of a mind: the grammar at a body's recogniser, and whose it is afterwards."""

from collections.abc import Collection

import pytest
from openrois_agents.mind.phrases import Phrases, make_phrases
from openrois_agents.tools.names import Vocabulary

from openrois.testing import memory_gateway
from tests.support.actors import Actor
from tests.support.conversing import Recognition, conversing, until

_OTHER = "#JSGF V1.0; grammar other; public <a> = yes;"


@pytest.mark.parametrize(("before", "afterwards"), [("default", "default"), (_OTHER, _OTHER)])
async def test_a_recogniser_expects_what_can_be_said_and_then_what_it_did_before(before: str, afterwards: str) -> None:
    actor, recognition = Actor(), Recognition()
    recognition.grammar = before
    async with memory_gateway(*actor.parts, recognition) as gateway:
        async with conversing(gateway.client, actor, make_phrases=_phrases):
            assert "wave" in recognition.grammar
            assert "plant" in recognition.grammar
        assert recognition.grammar == afterwards


async def test_a_grammar_that_a_mind_left_behind_is_not_put_back() -> None:
    actor, recognition = Actor(), Recognition()
    recognition.grammar = "#JSGF V1.0; grammar mind; public <heard> = bow;"
    async with memory_gateway(*actor.parts, recognition) as gateway:
        async with conversing(gateway.client, actor, make_phrases=_phrases):
            assert "wave" in recognition.grammar
        assert recognition.grammar == "default"


async def test_a_grammar_that_another_application_set_meanwhile_stays() -> None:
    actor, recognition = Actor(), Recognition()
    async with memory_gateway(*actor.parts, recognition) as gateway, gateway.client() as other:
        async with conversing(gateway.client, actor, make_phrases=_phrases):
            (info,) = await other.bodies()
            await other.component(info.refs("SpeechRecognition")[0]).set_parameter(grammar=_OTHER)
        assert recognition.grammar == _OTHER


async def test_a_recogniser_that_takes_no_grammar_is_heard_all_the_same() -> None:
    class Plain(Recognition):
        def accept_parameters(self, changes: dict[str, object]) -> dict[str, object]:
            from openrois.adapter import BadParameter

            raise BadParameter("this recogniser takes no grammar")

    Plain.__name__ = "SpeechRecognition"
    actor, recognition = Actor(), Plain()
    async with (
        memory_gateway(*actor.parts, recognition) as gateway,
        conversing(gateway.client, actor, make_phrases=_phrases) as talking,
    ):
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        assert recognition.grammar == "default"


def _phrases(names: Vocabulary, unknown: Collection[str]) -> Phrases:
    return make_phrases(names, unknown=unknown)
