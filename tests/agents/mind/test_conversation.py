"""Conversations before a gateway in memory: when they begin, what interrupts an answer, and when they end."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import pytest
from openrois_agents.mind.body_stage import MAX_WAITING
from openrois_agents.mind.consenting import Asked
from openrois_agents.mind.contract import Allowed, Stage, Turn
from openrois_agents.mind.conversation import SILENCE
from openrois_agents.mind.phrases import Phrases, make_phrases
from openrois_agents.mind.words import Words
from openrois_agents.tools.names import Vocabulary
from openrois_body.components.dialogue import Dialogue

from openrois.adapter import query
from openrois.component.component import Component
from openrois.testing import memory_gateway
from openrois.types.codes import Purpose
from tests.support.actors import Actor, Consented, Visitors
from tests.support.conversing import (
    MUCH,
    PATIENCE,
    Conversing,
    ScriptedMind,
    SpeechProgress,
    conversing,
    until,
)


def _no_phrases(_names: object, _unknown: object) -> Phrases:
    return make_phrases(Vocabulary())


@asynccontextmanager
async def talk(*more: Component, at_once: bool = True, **options: Any) -> AsyncIterator[Conversing]:
    actor = Actor(at_once)
    async with memory_gateway(*actor.parts, *more) as gateway, conversing(gateway.client, actor, **options) as talking:
        yield talking


async def test_the_first_words_begin_a_conversation_with_the_body_that_heard_them() -> None:
    async with talk() as talking:
        talking.hear("good", final=False)
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        assert talking.actor.speaking.did == ["You said good morning."]
        assert talking.session.held is not None
        assert (talking.figures.conversations, talking.figures.holds) == (1, 1)
        talking.hear("and you")
        await until(lambda: talking.figures.answers == 2)
        assert [(each.text, each.number) for each in talking.mind.turns] == [("good morning", 1), ("and you", 2)]
        assert talking.figures.conversations == 1


async def test_a_small_gesture_goes_with_the_words_unless_a_gesture_was_asked_for() -> None:
    async def wave(_turn: Turn, stage: Stage) -> None:
        await stage.use("gesture", {"name": "wave"})
        await stage.say("Hello.")

    async with talk() as talking:
        talking.hear("good morning")
        await until(lambda: talking.actor.gesturing.did == ["urn:x-rois:def:reaction:OMG::1"])
        await until(lambda: talking.figures.answers == 1)
        talking.mind.script = wave
        talking.hear("wave")
        await until(lambda: talking.figures.answers == 2)
        assert talking.actor.gesturing.did[1:] == ["urn:x-rois:def:reaction:OpenRoIS::wave"]


async def test_a_gesture_that_is_asked_for_ends_the_small_one() -> None:
    async def speak_and_wave(_turn: Turn, stage: Stage) -> None:
        await stage.say("Look.")
        await talking.actor.gesturing.begun.wait()
        talking.actor.gesturing.begun.clear()
        await stage.use("gesture", {"name": "wave"})

    async with talk(at_once=False) as talking:
        talking.mind.script = speak_and_wave
        talking.hear("wave")
        await until(lambda: len(talking.actor.gesturing.did) == 2)
        assert talking.actor.gesturing.did[1].endswith("wave")
        assert talking.actor.gesturing.stops == 1


async def test_words_interrupt_an_answer_and_what_it_began_and_the_mind_learns_what_was_heard() -> None:
    progress = SpeechProgress()
    stages: list[Any] = []

    async def tell(_turn: Turn, stage: Stage) -> None:
        stages.append(stage)
        await stage.say("You said so.")

    async with talk(progress, at_once=False) as talking:
        talking.mind.script = tell
        talking.hear("tell me a story")
        await talking.actor.speaking.begun.wait()
        assert progress.barge_in
        progress.word_spoken("1", "You", 0, 3, datetime.now(UTC))
        progress.word_spoken("1", "said", 4, 4, datetime.now(UTC))
        await until(lambda: stages[0].heard == "You said")
        talking.hear("no, another one")
        await until(lambda: len(talking.mind.turns) == 2)
        assert talking.mind.cut == ["You said"]
        assert talking.figures.interruptions == 1
        await until(lambda: len(talking.actor.speaking.did) == 2)
        assert talking.actor.speaking.stops == 1
    assert not progress.barge_in


async def test_stop_stops_at_once_also_while_it_is_being_said_and_is_no_turn() -> None:
    async def walk(_turn: Turn, stage: Stage) -> None:
        await stage.use("go_to", {"place": "plant"})

    async with talk(at_once=False) as talking:
        talking.mind.script = walk
        talking.hear("go to the plant")
        await talking.actor.walking.begun.wait()
        talking.hear("stop", final=False)
        await talking.actor.walking.stopped.wait()
        talking.hear("stop please")
        await until(lambda: talking.figures.stops == 1)
        talking.hear("stop")
        await until(lambda: talking.figures.stops == 2)
        assert len(talking.mind.turns) == 1
        assert talking.figures.holds == 1


async def test_speech_that_is_not_understood_is_a_turn_unless_the_mind_speaks() -> None:
    async with talk(at_once=False, make_phrases=_no_phrases) as talking:
        talking.hear("", final=False)
        talking.hear("good morning")
        await talking.actor.speaking.begun.wait()
        talking.hear("")
        talking.actor.speaking.may_end.set()
        await until(lambda: talking.figures.answers == 1)
        assert talking.figures.interruptions == 0
        talking.hear("")
        await until(lambda: talking.figures.answers == 2)
        assert [each.text for each in talking.mind.turns] == ["good morning", ""]


@pytest.mark.parametrize("options", [{"wake_word": "computer", "make_phrases": _no_phrases}, {}])
async def test_speech_that_is_not_understood_is_no_turn_without_the_wake_word_or_a_grammar(
    options: dict[str, Any],
) -> None:
    async with talk(**options) as talking:
        talking.hear("")
        talking.hear("computer hello")
        await until(lambda: talking.figures.answers == 1)
        assert [each.text for each in talking.mind.turns] == ["computer hello"]


async def test_what_was_taken_for_stop_at_first_leaves_the_next_stop_heeded() -> None:
    async with talk(wake_word="computer") as talking:
        talking.hear("computer hello")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("stop", final=False)
        talking.hear("stop at the lamp")
        talking.hear("stop")
        await until(lambda: talking.figures.stops == 2)


async def test_a_conversation_ends_after_silence_but_not_while_it_answers() -> None:
    async with talk(at_once=False) as talking:
        talking.hear("good morning")
        await talking.actor.speaking.begun.wait()
        talking.clock.now += SILENCE + 1
        talking.ticks.put_nowait(None)
        await until(talking.ticks.empty)
        assert talking.figures.holds == 1
        talking.actor.speaking.may_end.set()
        await until(lambda: talking.figures.answers == 1)
        talking.clock.now += SILENCE + 1
        await talking.until_free()
        assert talking.session.held is None
        assert talking.mind.forgotten == 1


async def test_a_goodbye_ends_a_conversation_behind_its_answer() -> None:
    async with talk() as talking:
        talking.hear("goodbye")
        await until(lambda: talking.figures.answers == 1)
        await talking.until_free()
        assert talking.actor.speaking.did == ["You said goodbye."]


async def test_with_a_wake_word_other_words_are_not_for_the_mind() -> None:
    async with talk(wake_word="computer") as talking:
        talking.hear("what a nice day")
        talking.hear("computer what do you see")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("he said something to her")
        talking.hear("computer who are you")
        await until(lambda: talking.figures.answers == 2)
        assert [each.text for each in talking.mind.turns] == ["computer what do you see", "computer who are you"]
        assert talking.figures.interruptions == 0


async def test_with_a_wake_word_other_words_silence_the_body_and_begin_nothing() -> None:
    async with talk(at_once=False, wake_word="computer") as talking:
        talking.hear("computer tell me a story")
        await talking.actor.speaking.begun.wait()
        talking.hear("what a nice")
        await talking.actor.speaking.stopped.wait()
        await until(lambda: talking.figures.interruptions == 1)
        talking.actor.speaking.may_end.set()
        talking.hear("computer who are you")
        await until(lambda: talking.figures.answers == 1)
        assert [each.text for each in talking.mind.turns] == ["computer tell me a story", "computer who are you"]


async def test_a_limit_is_said_once_and_ends_the_conversation() -> None:
    async with talk(limits=(MUCH, replace(MUCH, turns=1))) as talking:
        talking.hear("one")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("two")
        await talking.until_free()
        assert talking.actor.speaking.did[1:] == ["I have talked as much as I may today. Please come back tomorrow."]
        talking.hear("three")
        await until(lambda: talking.figures.refusals["limit"] == 2)
        assert len(talking.actor.speaking.did) == 2
        assert len(talking.mind.turns) == 1


@pytest.mark.parametrize("sends_to", ["", "https://model.example.org"])
async def test_a_visitor_who_does_not_consent_is_asked_and_no_words_go_to_the_mind(sends_to: str) -> None:
    async with talk(mind=ScriptedMind(sends_to, needs_visitor=True)) as talking:
        talking.hear("good morning", visitor="v1")
        await until(lambda: len(talking.actor.speaking.did) == 1)
        (said,) = talking.actor.speaking.did
        assert "a program that answers gets your words" in said
        assert ("another machine" in said) is (sends_to != "")
        assert not talking.mind.turns
        assert talking.figures.refusals["consent"] == 1


async def test_rules_answer_a_visitor_who_consents_and_what_a_body_hears_itself() -> None:
    visitors = Visitors({"v1": "recognition", "v2": "agent recognition"})
    async with talk(visitors, mind=ScriptedMind()) as talking:
        talking.hear("good morning", visitor="v1")
        await until(lambda: talking.figures.refusals["consent"] == 1)
        talking.hear("good day", visitor="v2")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("good evening")
        await until(lambda: talking.figures.answers == 2)
        assert [each.text for each in talking.mind.turns] == ["good day", "good evening"]


async def test_a_body_that_another_application_has_is_not_answered_with() -> None:
    actor = Actor()
    async with (
        memory_gateway(*actor.parts) as gateway,
        gateway.client() as other,
        other.bound("robot/speech_synthesizer"),
        conversing(gateway.client, actor) as talking,
    ):
        talking.hear("good morning")
        await until(lambda: talking.figures.refusals["busy"] == 1)
        assert talking.session.held is None
        assert not talking.mind.turns


async def _fail(_turn: Turn, _stage: Stage) -> None:
    raise ValueError("a mistake of the mind")


async def test_a_mind_that_fails_is_told_and_leaves_the_conversation_as_it_is(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with talk() as talking:
        talking.mind.script = _fail
        talking.hear("good morning")
        await until(lambda: talking.actor.speaking.did == ["I am sorry, something went wrong."])
        assert "a mistake of the mind" in caplog.text
        talking.mind.script = ScriptedMind().script
        talking.hear("again")
        await until(lambda: talking.figures.answers == 1)
        assert talking.figures.conversations == 1


async def test_a_goodbye_ends_a_conversation_also_where_the_mind_fails() -> None:
    async with talk() as talking:
        talking.mind.script = _fail
        talking.hear("goodbye")
        await until(lambda: len(talking.mind.turns) == 1)
        await talking.until_free()
        assert talking.actor.speaking.did == ["I am sorry, something went wrong."]


async def test_a_mistake_outside_of_an_answer_ends_the_conversation_and_the_next_one_is_led(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_arguments: object) -> bool:
        raise KeyError("a mistake of a body")

    async with talk() as talking:
        with monkeypatch.context() as patched:
            patched.setattr("openrois_agents.mind.conversation.is_goodbye", fail)
            talking.hear("good morning")
            await until(lambda: "a mistake of a body" in caplog.text)
            await talking.until_free()
        assert talking.session.held is None
        talking.hear("again")
        await until(lambda: talking.figures.answers == 1)
        assert talking.figures.conversations == 2


async def test_a_tool_that_fails_is_an_answer_and_the_body_is_the_conversations() -> None:
    answers: list[str] = []

    async def try_both(_turn: Turn, stage: Stage) -> None:
        for tool, arguments in (("give_back", {}), ("gesture", {"name": "fly"})):
            answers.append((await stage.use(tool, arguments)).data["failed"])

    async with talk() as talking:
        talking.mind.script = try_both
        talking.hear("fly away")
        await until(lambda: talking.figures.answers == 1)
        assert answers == ["Unsupported", "BadParameter"]


async def test_a_mind_that_stops_its_body_is_not_interrupted_by_that_and_says_more() -> None:
    async def stop(_turn: Turn, stage: Stage) -> None:
        await stage.say("I walk and talk.")
        await talking.actor.speaking.begun.wait()
        assert "failed" not in (await stage.use("stop", {})).data
        talking.actor.speaking.may_end.set()
        await stage.say("I have stopped.")

    async with talk(at_once=False) as talking:
        talking.mind.script = stop
        talking.hear("please end all of it")
        await until(lambda: talking.figures.answers + talking.figures.interruptions == 1)
        assert talking.actor.speaking.stops == 1
        assert talking.actor.speaking.did == ["I walk and talk.", "I have stopped."]
        assert talking.figures.interruptions == 0


async def test_a_conversation_that_is_ended_from_outside_gives_its_body_back() -> None:
    actor = Actor(at_once=False)
    async with memory_gateway(*actor.parts) as gateway, gateway.client() as other:
        async with conversing(gateway.client, actor) as talking:
            talking.hear("good morning")
            await actor.speaking.begun.wait()
        (info,) = await other.bodies()
        assert info.free
        assert actor.speaking.stops >= 1


async def test_a_mind_waits_while_four_sentences_wait_to_be_spoken() -> None:
    queued: list[int] = []

    async def talk_much(_turn: Turn, stage: Stage) -> None:
        for number in range(10):
            await stage.say(f"Sentence {number}.")
            queued.append(number)

    async with talk(at_once=False) as talking:
        talking.mind.script = talk_much
        talking.hear("tell me everything")
        await until(lambda: talking.actor.speaking.begun.is_set() and len(queued) == MAX_WAITING + 1)
        talking.actor.speaking.may_end.set()
        await until(lambda: talking.figures.answers == 1)
        assert talking.actor.speaking.did == [f"Sentence {number}." for number in range(10)]


async def test_a_body_shows_where_words_go_and_the_wake_word_in_a_conversation() -> None:
    dialogue = Dialogue()
    async with talk(dialogue, mind=ScriptedMind("https://model.example.org"), wake_word="computer") as talking:
        talking.hear("computer hello")
        await until(lambda: talking.figures.answers == 1)
        assert (dialogue.sent_to, dialogue.wake_word) == ("https://model.example.org", "computer")


async def test_words_of_a_visitor_whose_consent_ended_are_forgotten_before_another_is_answered() -> None:
    visitors = Visitors({"v1": "agent", "v2": "agent"})
    async with talk(visitors, mind=ScriptedMind(needs_visitor=True)) as talking:
        talking.hear("my name is Ann", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("good morning", visitor="v2")
        await until(lambda: talking.figures.answers == 2)
        assert not talking.mind.forgotten
        visitors.consents["v1"] = ""
        talking.hear("what did she say", visitor="v2")
        await until(lambda: talking.figures.answers == 3)
        assert talking.mind.forgotten == 1


async def test_a_mind_asks_anew_what_may_go_to_a_model_and_no_picture_is_taken_without_the_consent_of_all() -> None:
    visitors = Visitors({"v1": "agent", "v2": "agent"})
    found: list[Any] = []

    async def ask(_turn: Turn, stage: Stage) -> None:
        for changes in ({}, {"v2": "live"}, {"v1": "live", "v2": "agent"}):
            visitors.consents |= changes
            found.append((await stage.allowed(), (await stage.use("look", {})).text))

    async with talk(visitors, mind=ScriptedMind(needs_visitor=True)) as talking:
        talking.mind.script = ask
        talking.hear("what do you see", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        refused = "Unsupported: no picture is taken while a visitor is here who does not consent to that"
        assert found == [
            (Allowed(words=True, pictures=True), "Unsupported: robot has no camera"),
            (Allowed(words=True, pictures=False), refused),
            (Allowed(words=False, pictures=False), refused),
        ]


async def test_what_a_visitor_said_who_has_left_may_be_used_in_its_answer_until_it_is_there_without_consent() -> None:
    visitors = Visitors({"v1": "agent", "v2": "agent"})
    found: list[Allowed] = []

    async def ask(_turn: Turn, stage: Stage) -> None:
        del visitors.consents["v1"]
        found.append(await stage.allowed())
        visitors.is_broken = True
        found.append(await stage.allowed())
        visitors.is_broken = False
        found.append(await stage.allowed())
        visitors.consents["v1"] = "live"
        found.append(await stage.allowed())
        del visitors.consents["v1"]
        found.append(await stage.allowed())

    async with talk(visitors, mind=ScriptedMind(needs_visitor=True)) as talking:
        talking.mind.script = ask
        talking.hear("go to the plant", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        everything, nothing = Allowed(words=True, pictures=True), Allowed(words=False, pictures=False)
        assert found == [everything, nothing, everything, nothing, nothing]


async def test_a_consent_that_is_withdrawn_just_before_its_visitor_leaves_is_withdrawn() -> None:
    visitors = Visitors({"v1": "agent"})

    async def ask(_turn: Turn, stage: Stage) -> None:
        visitors.visitor_changed("v1", "microphone", "live")
        del visitors.consents["v1"]
        visitors.visitor_changed("v1", "", "")
        async with asyncio.timeout(PATIENCE):
            while (await stage.allowed()).words:
                pass

    async with talk(visitors, mind=ScriptedMind(needs_visitor=True)) as talking:
        talking.mind.script = ask
        talking.hear("go to the plant", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        assert talking.actor.speaking.did == []


async def test_what_a_visitor_said_who_has_left_is_forgotten_before_another_is_answered() -> None:
    visitors = Visitors({"v1": "agent", "v2": "agent"})
    async with talk(visitors, mind=ScriptedMind(needs_visitor=True)) as talking:
        talking.hear("my name is Ann", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        del visitors.consents["v1"]
        talking.hear("what is my name", visitor="v1")
        await until(lambda: talking.figures.answers == 2)
        assert not talking.mind.forgotten
        talking.hear("what did she say", visitor="v2")
        await until(lambda: talking.figures.answers == 3)
        assert talking.mind.forgotten == 1


async def test_a_noise_of_a_visitor_who_does_not_consent_is_not_answered_and_no_body_is_held_for_it() -> None:
    visitors = Visitors({"v1": "recognition", "v2": "agent recognition"})
    async with talk(visitors, make_phrases=_no_phrases) as talking:
        talking.hear("", visitor="v1")
        talking.hear("good morning", visitor="v2")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("", visitor="v1")
        talking.hear("good day", visitor="v2")
        await until(lambda: talking.figures.answers == 2)
        assert talking.actor.speaking.did == ["You said good morning.", "You said good day."]
        assert (talking.figures.conversations, talking.mind.forgotten) == (1, 0)


async def test_a_visitor_is_asked_for_consent_once_and_no_body_is_held_to_repeat_that() -> None:
    visitors = Visitors({"v1": "recognition"})
    async with talk(visitors, mind=ScriptedMind("https://model.example.org")) as talking:
        talking.hear("good morning", visitor="v1")
        await until(lambda: talking.figures.conversations == 1 and talking.figures.holds == 0)
        for refused in (2, 3):
            talking.clock.now += SILENCE
            talking.hear("are you there", visitor="v1")
            await until(lambda refused=refused: talking.figures.refusals["consent"] == refused)  # type: ignore[misc]
        assert (talking.figures.conversations, len(talking.actor.speaking.did)) == (1, 1)
        # What is missing is not the same any more.
        visitors.consents["v1"] = "recognition agent"
        talking.hear("and now", visitor="v1")
        await until(lambda: talking.figures.conversations == 2 and talking.figures.holds == 0)
        assert "another machine" in talking.actor.speaking.did[1]
        assert "a program" not in talking.actor.speaking.did[1]
        # It was silent as long as ends a conversation.
        talking.clock.now += SILENCE + 1
        talking.hear("good evening", visitor="v1")
        await until(lambda: talking.figures.conversations == 3 and talking.figures.holds == 0)
        visitors.consents["v1"] = "recognition agent transfer"
        talking.hear("good night", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        visitors.consents["v1"] = "recognition agent"
        talking.hear("and I say", visitor="v1")
        await until(lambda: talking.figures.refusals["consent"] == 6)
        assert [each.text for each in talking.mind.turns] == ["good night"]


async def test_a_visitor_who_does_not_consent_is_asked_once_in_a_conversation_and_ends_it_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    visitors, asked = Visitors({"v1": "agent", "v2": "live"}), asyncio.Event()

    class Noted(Asked):
        def add(self, visitor: str, missing: Sequence[Purpose]) -> None:
            super().add(visitor, missing)
            asked.set()

    monkeypatch.setattr("openrois_agents.mind.conversation.Asked", Noted)
    async with talk(visitors) as talking:
        talking.hear("good morning", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("hello", visitor="v2")
        async with asyncio.timeout(PATIENCE):
            await asked.wait()
        for number in range(2, 5):
            talking.hear("well", visitor="v1")
            await until(lambda number=number: talking.figures.answers == number)  # type: ignore[misc]
            talking.clock.now += SILENCE
            talking.hear("hello", visitor="v2")
            await until(lambda number=number: talking.figures.refusals["consent"] == number)  # type: ignore[misc]
        assert sum("I may only" in each for each in talking.actor.speaking.did) == 1
        assert (talking.figures.turns, talking.mind.forgotten) == (5, 1)
        assert (talking.figures.conversations, talking.figures.holds) == (1, 1)


async def test_of_many_visitors_who_do_not_consent_the_first_is_asked_again() -> None:
    visitors = Visitors({})
    async with talk(visitors) as talking:
        talking.hear("hello", visitor="v0")
        for number in range(1, 65):
            await until(lambda: talking.figures.conversations == number and talking.figures.holds == 0)  # noqa: B023
            talking.hear("hello", visitor=f"v{number}")
        await until(lambda: talking.figures.conversations == 65 and talking.figures.holds == 0)
        talking.hear("hello", visitor="v64")
        await until(lambda: talking.figures.refusals["consent"] == 66)
        assert talking.figures.conversations == 65
        talking.hear("hello", visitor="v0")
        await until(lambda: talking.figures.conversations == 66)


async def test_a_visitor_of_whom_no_consent_is_told_has_given_none() -> None:
    class Forgetful(Visitors):
        @query
        async def visitors(self) -> Consented:
            return Consented(visitor_ref=("v1", "v2"), consent=("agent",))

    found: list[Allowed] = []

    async def ask(_turn: Turn, stage: Stage) -> None:
        found.append(await stage.allowed())

    async with talk(Forgetful({}), mind=ScriptedMind(needs_visitor=True)) as talking:
        talking.mind.script = ask
        talking.hear("what do you see", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        assert found == [Allowed(words=True, pictures=False)]


async def test_a_flood_of_words_that_are_being_said_pushes_nothing_else_out() -> None:
    async with talk() as talking:
        talking.conversations.hear(Words("good morning", True, "", "robot"))
        for _ in range(200):
            talking.conversations.hear(Words("good", False, "", "robot"))
        await until(lambda: talking.figures.answers == 1)
