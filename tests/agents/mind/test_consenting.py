"""Whether a mind may have what visitors say: consent that is given, lacking, withdrawn, and left behind."""

import asyncio
from collections.abc import Sequence
from typing import Any

import pytest
from openrois_agents.mind.consenting import Asked
from openrois_agents.mind.contract import Allowed, Stage, Turn
from openrois_agents.mind.conversation import SILENCE

from openrois.adapter import query
from openrois.types.codes import Purpose
from tests.support.actors import Consented, Visitors
from tests.support.conversing import (
    PATIENCE,
    ScriptedMind,
    no_phrases,
    talk,
    until,
)


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
    async with talk(visitors, make_phrases=no_phrases) as talking:
        talking.hear("", visitor="v1")
        talking.hear("good morning", visitor="v2")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("", visitor="v1")
        talking.hear("good day", visitor="v2")
        await until(lambda: talking.figures.answers == 2)
        assert talking.actor.speaking.did == ["You said good morning.", "You said good day."]
        assert (talking.figures.conversations, talking.mind.forgotten) == (1, 0)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The visitors who were asked for consent, to the end of the sentence, or have spoken all the same."""
    noted: list[str] = []

    class Noted(Asked):
        def add(self, visitor: str, missing: Sequence[Purpose]) -> None:
            super().add(visitor, missing)
            noted.append(visitor)

    monkeypatch.setattr("openrois_agents.mind.conversation.Asked", Noted)
    return noted


async def test_a_visitor_is_asked_once_and_again_for_other_consent_and_in_another_conversation(
    asked: list[str],
) -> None:
    visitors = Visitors({"v1": "recognition"})
    async with talk(visitors, mind=ScriptedMind("https://model.example.org")) as talking:
        talking.hear("good morning", visitor="v1")
        await until(lambda: len(asked) == 1)
        # The body is held, and shows what to agree to.
        assert talking.figures.holds == 1
        talking.hear("are you there", visitor="v1")
        await until(lambda: talking.figures.refusals["consent"] == 2)
        assert len(talking.actor.speaking.did) == 1
        visitors.consents["v1"] = "recognition agent"
        talking.hear("and now", visitor="v1")
        await until(lambda: len(asked) == 3)
        assert "another machine" in talking.actor.speaking.did[1]
        assert "a program" not in talking.actor.speaking.did[1]
        talking.clock.now += SILENCE + 1
        await talking.until_free()
        talking.hear("good evening", visitor="v1")
        await until(lambda: len(asked) == 4)
        assert (talking.figures.conversations, len(talking.actor.speaking.did)) == (2, 3)
        visitors.consents["v1"] = "recognition agent transfer"
        talking.hear("good night", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        visitors.consents["v1"] = "recognition agent"
        talking.hear("and I say", visitor="v1")
        await until(lambda: talking.figures.refusals["consent"] == 5)
        assert [each.text for each in talking.mind.turns] == ["good night"]


async def test_a_visitor_who_does_not_consent_is_asked_once_in_a_conversation_and_ends_it_not(
    asked: list[str],
) -> None:
    visitors = Visitors({"v1": "agent", "v2": "live"})
    async with talk(visitors) as talking:
        talking.hear("good morning", visitor="v1")
        await until(lambda: talking.figures.answers == 1)
        talking.hear("hello", visitor="v2")
        await until(lambda: asked == ["v2"])
        for number in range(2, 5):
            talking.hear("well", visitor="v1")
            await until(lambda number=number: talking.figures.answers == number)  # type: ignore[misc]
            talking.clock.now += SILENCE
            talking.hear("hello", visitor="v2")
            await until(lambda number=number: talking.figures.refusals["consent"] == number)  # type: ignore[misc]
        assert sum("I may only" in each for each in talking.actor.speaking.did) == 1
        assert (talking.figures.turns, talking.mind.forgotten) == (5, 1)
        assert (talking.figures.conversations, talking.figures.holds) == (1, 1)


async def test_of_many_visitors_who_do_not_consent_the_first_is_asked_again(asked: list[str]) -> None:
    async with talk(Visitors({})) as talking:
        for number in range(65):
            talking.hear("hello", visitor=f"v{number}")
            await until(lambda: len(asked) == number + 1)  # noqa: B023
        said = len(talking.actor.speaking.did)
        talking.hear("hello", visitor="v64")
        await until(lambda: talking.figures.refusals["consent"] == 66)
        assert len(talking.actor.speaking.did) == said
        talking.hear("hello", visitor="v0")
        await until(lambda: len(talking.actor.speaking.did) == said + 1)


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
