"""Conversations before a gateway in memory: when they begin, what interrupts an answer, and when they end."""

from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import pytest
from openrois_agents.mind.body_stage import MAX_WAITING
from openrois_agents.mind.contract import Stage, Turn
from openrois_agents.mind.conversation import SILENCE
from openrois_agents.mind.words import Words
from openrois_body.components.dialogue import Dialogue

from openrois.testing import memory_gateway
from tests.support.actors import Actor
from tests.support.conversing import (
    MUCH,
    ScriptedMind,
    SpeechProgress,
    conversing,
    no_phrases,
    talk,
    until,
)


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
    async with talk(at_once=False, make_phrases=no_phrases) as talking:
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


@pytest.mark.parametrize("options", [{"wake_word": "computer", "make_phrases": no_phrases}, {}])
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


async def test_a_flood_of_words_that_are_being_said_pushes_nothing_else_out() -> None:
    async with talk() as talking:
        talking.conversations.hear(Words("good morning", True, "", "robot"))
        for _ in range(200):
            talking.conversations.hear(Words("good", False, "", "robot"))
        await until(lambda: talking.figures.answers == 1)
