"""A conversation before a gateway of real connections: a person stops its body, or it dies."""

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path

from openrois_body.components.dialogue import Dialogue

from openrois.client.components import SpeechSynthesis
from tests.support.actors import Actor, Visitors
from tests.support.conversing import PATIENCE, Conversing, ScriptedMind, SpeechProgress, conversing, until
from tests.support.conversing_site import conversing_site


async def test_a_person_who_stops_the_body_ends_the_conversation_until_it_is_handed_back(tmp_path: Path) -> None:
    actor = Actor(at_once=False)
    async with (
        conversing_site(tmp_path) as site,
        site.body("robot", actor),
        site.client("ann", "person") as person,
        conversing(site.client, actor) as talking,
    ):
        talking.hear("good morning")
        await actor.speaking.begun.wait()
        await person.control.stop_all("robot")
        await talking.until_free()
        await site.until("robot", free=True)
        assert talking.mind.forgotten == 1
        talking.hear("are you there")
        actor.speaking.may_end.set()
        await person.control.release_stop("robot")
        async with asyncio.timeout(PATIENCE):
            while not talking.figures.answers:
                talking.hear("are you there now")
                await asyncio.sleep(0.2)  # a visitor repeats it
        assert {each.text for each in talking.mind.turns[1:]} == {"are you there now"}


async def test_a_conversation_goes_on_with_another_body_when_its_own_dies(tmp_path: Path) -> None:
    first, second = Actor(), Actor()
    async with conversing_site(tmp_path) as site, AsyncExitStack() as stack, AsyncExitStack() as dying:
        await stack.enter_async_context(site.body("first", first))
        await dying.enter_async_context(site.body("second", second))
        talking = await stack.enter_async_context(conversing(site.client, second))
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        assert _held(talking) == "second"
        await dying.aclose()
        await until(lambda: first.speaking.did == ["I go on here."])
        assert _held(talking) == "first"
        first.hearing.heard("thank you", True)
        await until(lambda: talking.figures.answers == 2)
        assert (talking.figures.conversations, talking.figures.moves) == (1, 1)
        assert talking.mind.turns[-1].number == 2


async def test_another_body_has_other_visitors_and_what_those_of_the_lost_one_said_is_forgotten_before_one_is_answered(
    tmp_path: Path,
) -> None:
    first = Actor(visitors=Visitors({"v1": "agent"}))
    second = Actor(visitors=Visitors({"v2": "agent"}))
    async with conversing_site(tmp_path) as site, AsyncExitStack() as stack, AsyncExitStack() as dying:
        await stack.enter_async_context(site.body("first", first))
        await dying.enter_async_context(site.body("second", second))
        mind = ScriptedMind(needs_visitor=True)
        talking = await stack.enter_async_context(conversing(site.client, second, mind=mind))
        talking.hear("my name is Ann", visitor="v2")
        await until(lambda: talking.figures.answers == 1)
        await dying.aclose()
        await until(lambda: first.speaking.did == ["I go on here."])
        assert talking.mind.forgotten == 0
        first.hearing.heard("who was here", True, None, "v1")
        await until(lambda: talking.figures.answers == 2)
        assert talking.mind.forgotten == 1
        assert (talking.figures.conversations, talking.mind.turns[-1].number) == (1, 2)


def _held(talking: Conversing) -> str:
    held = talking.session.held
    return "" if held is None else held.engine_id


async def test_a_conversation_is_over_when_its_body_dies_and_there_is_no_other(tmp_path: Path) -> None:
    actor = Actor()
    async with conversing_site(tmp_path) as site, AsyncExitStack() as stack, AsyncExitStack() as dying:
        await dying.enter_async_context(site.body("lone", actor))
        talking = await stack.enter_async_context(conversing(site.client, actor))
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        await dying.aclose()
        await talking.until_free()
        assert talking.session.held is None
        assert talking.mind.forgotten == 1


async def test_after_a_loan_of_the_voice_it_yields_and_shows_the_conversation_again(tmp_path: Path) -> None:
    actor, dialogue, progress = Actor(), Dialogue(), SpeechProgress()
    mind = ScriptedMind("https://model.example.org")
    async with (
        conversing_site(tmp_path) as site,
        site.body("robot", actor, dialogue, progress),
        site.client("ann", "person") as person,
        conversing(site.client, actor, mind=mind, wake_word="computer") as talking,
    ):
        talking.hear("computer good morning")
        await until(lambda: talking.figures.answers == 1)
        assert (dialogue.sent_to, dialogue.wake_word, progress.barge_in) == (mind.sends_to, "computer", True)
        for component_ref in ("robot/dialogue", "robot/speech_progress", "robot/speech_synthesizer"):
            await person.control.borrow(component_ref)
        await until(lambda: dialogue.sent_to == "")
        await person.component("robot/speech_progress").set_parameter(barge_in=False)
        for component_ref in ("robot/speech_synthesizer", "robot/speech_progress", "robot/dialogue"):
            await person.control.give_back(component_ref)
        await until(lambda: dialogue.sent_to == mind.sends_to and progress.barge_in)
        assert dialogue.wake_word == "computer"


async def test_after_one_sentence_of_a_person_the_conversation_is_shown_as_before(tmp_path: Path) -> None:
    actor, dialogue, progress = Actor(), Dialogue(), SpeechProgress()
    mind = ScriptedMind("https://model.example.org")
    async with (
        conversing_site(tmp_path) as site,
        site.body("robot", actor, dialogue, progress),
        site.client("ann", "person") as person,
        conversing(site.client, actor, mind=mind) as talking,
    ):
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        await person.control.borrow("robot/speech_synthesizer", for_one_command=True)
        await person.component(SpeechSynthesis, "robot/speech_synthesizer").start()
        await talking.session.log.wait(0, ("part_came_back",), PATIENCE)
        talking.hear("go on")
        await until(lambda: talking.figures.answers == 2)
        await until(lambda: dialogue.sent_to == mind.sends_to and progress.barge_in)
