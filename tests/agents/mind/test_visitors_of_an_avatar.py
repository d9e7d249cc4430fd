"""Minds in an avatar's body: real visitors send to it, consent, withdraw that, and speak while it speaks."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import pytest
from openrois_agents.mind.contract import Mind
from openrois_agents.mind.conversation import Conversations
from openrois_agents.mind.ears import Ears
from openrois_agents.mind.figures import MindFigures
from openrois_agents.mind.limits import Budget
from openrois_agents.mind.model.chat import ModelSettings
from openrois_agents.mind.model.model_mind import ModelMind
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings
from openrois_media import Media, Purpose
from openrois_media.client.sending import Sending

from openrois.client import Client
from tests.support.chat_server import Behaviour, ChatServer, call_chunk, chat_server, chunk, halting, says
from tests.support.conversing import MUCH, PATIENCE, ScriptedMind, until
from tests.support.guided import House, house, token
from tests.support.hearing import voice
from tests.support.microphone import Microphone

pytestmark = [pytest.mark.media, pytest.mark.timeout(180)]

STORY = "Once there was a robot who liked to talk with all of its visitors."
CONSENT = (Purpose.RECOGNITION, Purpose.AGENT)


@dataclass
class Guest:
    """A visitor whose microphone the avatar gets."""

    microphone: Microphone
    sending: Sending
    ref: str


@asynccontextmanager
async def guest(opened: House, *consent: Purpose) -> AsyncIterator[Guest]:
    microphone = Microphone()
    visitors = opened.client.component("avatar/visitors")
    before = set((await visitors.query("visitors"))["visitor_ref"])
    async with (
        Client(opened.url, token=token("visitor", roles=["visitor"])) as client,
        Media(client) as media,
        media.send(microphone=microphone, consent=consent, to="avatar") as sending,
    ):
        async with asyncio.timeout(PATIENCE):
            while not (new := set((await visitors.query("visitors"))["visitor_ref"]) - before):
                pass
        yield Guest(microphone, sending, new.pop())


@asynccontextmanager
async def conversation(opened: House, mind: Mind) -> AsyncIterator[MindFigures]:
    """Let a mind converse while the block runs."""
    figures, budget = MindFigures(), Budget(MUCH, MUCH, lambda: date(2026, 1, 1))
    async with Session(lambda: Client(opened.url, token=token("mind", rank="agent")), ToolSettings()) as session:
        talk = Conversations(session, mind, budget, figures)
        async with Ears(session, talk.hear, None):
            running = asyncio.ensure_future(talk.run())
            try:
                yield figures
            finally:
                running.cancel()
                await asyncio.wait({running})


async def story_begins(opened: House, ask: Callable[[], None]) -> None:
    """Ask for the story, and wait until the avatar tells it."""
    async with (
        opened.client.component("avatar/speech_progress").event("word_spoken") as words,
        asyncio.timeout(PATIENCE),
    ):
        ask()
        async for data in words:
            if data["word"] == "there":
                return


@asynccontextmanager
async def model(*script: Behaviour) -> AsyncIterator[tuple[ModelMind, ChatServer]]:
    """Run a server with a language model, and a mind that asks it."""
    async with AsyncExitStack() as stack:
        server = await stack.enter_async_context(chat_server())
        server.script.extend(script)
        budget = Budget(MUCH, MUCH, lambda: date(2026, 1, 1))
        yield await stack.enter_async_context(ModelMind(ModelSettings(server.address, "m"), budget)), server


async def test_a_voice_cuts_the_speech_and_the_mind_learns_what_was_heard(tmp_path: Path) -> None:
    mind = ScriptedMind()
    async with (
        house(tmp_path) as opened,
        conversation(opened, mind) as figures,
        guest(opened, *CONSENT) as ann,
    ):
        opened.synthesizer.seconds = 30.0
        await story_begins(opened, lambda: opened.say(STORY, ann.ref))
        ann.microphone.say(voice(1.0))
        await until(lambda: figures.interruptions == 1)
        (heard,) = mind.cut
        said = f"You said {STORY}."
        assert said.startswith(heard)
        assert 0 < len(heard) < len(said)
        assert figures.answers == 0


async def test_a_voice_cancels_the_answer_of_a_language_model_and_its_history_has_what_was_heard(
    tmp_path: Path,
) -> None:
    script = (halting(chunk({"content": f"{STORY} And then"})), says("Where was I?"))
    async with (
        model(*script) as (mind, server),
        house(tmp_path) as opened,
        conversation(opened, mind) as figures,
        guest(opened, *CONSENT) as ann,
    ):
        opened.synthesizer.seconds = 30.0
        await story_begins(opened, lambda: opened.say("tell me a story", ann.ref))
        ann.microphone.say(voice(1.0))
        async with asyncio.timeout(PATIENCE):
            await server.broken.wait()
        await until(lambda: figures.interruptions == 1)
        opened.synthesizer.seconds = 0.2
        opened.say("go on", ann.ref)
        await opened.tells("Where was I?")
        (told,) = (each["content"] for each in server.asked[1]["messages"] if each["role"] == "assistant")
        assert told.startswith("Once there")
        assert "visitors" not in told
        assert "And then" not in json.dumps(server.asked[1])


async def test_who_consents_is_answered_who_does_not_is_told_and_a_withdrawal_is_obeyed(tmp_path: Path) -> None:
    script = (says("Hello to you."), says("Welcome back."))
    async with (
        model(*script) as (mind, server),
        house(tmp_path) as opened,
        conversation(opened, mind) as figures,
        guest(opened, *CONSENT) as ann,
        guest(opened, Purpose.RECOGNITION) as bob,
    ):
        opened.say("good morning", ann.ref)
        await opened.tells("Hello to you.", by="avatar")
        opened.say("the secret of the second visitor", bob.ref)
        await opened.tells("I may only answer you if you agree that a program", by="avatar")
        assert (figures.refusals["consent"], len(server.asked)) == (1, 1)
        await ann.sending.consent(Purpose.RECOGNITION)
        opened.say("the secret of the first visitor", ann.ref)
        await opened.tells("I may only answer you if you agree that a program", by="avatar")
        assert (figures.refusals["consent"], len(server.asked)) == (2, 1)
        await ann.sending.consent(*CONSENT)
        opened.say("here I am again", ann.ref)
        await opened.tells("Welcome back.", by="avatar")
        asked = json.dumps(server.asked[1])
        assert "here I am again" in asked
        assert "secret" not in asked
        assert "good morning" not in asked


async def test_a_withdrawal_while_an_answer_is_made_is_obeyed_before_the_next_request(tmp_path: Path) -> None:
    script = (halting(chunk({"content": "A moment. I"}), rest=[call_chunk(0, "{}", "where")]), says("Never."))
    async with (
        model(*script) as (mind, server),
        house(tmp_path) as opened,
        conversation(opened, mind) as figures,
        guest(opened, *CONSENT) as ann,
    ):
        opened.say("where is my secret", ann.ref)
        await opened.tells("A moment.", by="avatar")
        await ann.sending.consent(Purpose.RECOGNITION)
        server.go_on.set()
        await opened.tells("I am sorry, I stop here: the consent that I need is not there any more.", by="avatar")
        await until(lambda: figures.answers == 1)
        assert len(server.asked) == 1


async def test_a_visitor_who_lets_go_of_the_microphone_is_answered_to_the_end(tmp_path: Path) -> None:
    script = (halting(chunk({"content": "A moment. I"}), rest=[call_chunk(0, "{}", "where")]), says("At the plant."))
    async with (
        model(*script) as (mind, server),
        house(tmp_path) as opened,
        conversation(opened, mind) as figures,
        AsyncExitStack() as talked,
    ):
        ann = await talked.enter_async_context(guest(opened, *CONSENT))
        opened.say("where are you", ann.ref)
        await opened.tells("A moment.", by="avatar")
        await talked.aclose()
        visitors = opened.client.component("avatar/visitors")
        assert (await visitors.query("visitors"))["visitor_ref"] == []
        server.go_on.set()
        await opened.tells("At the plant.", by="avatar")
        await until(lambda: figures.answers == 1)
        assert len(server.asked) == 2
