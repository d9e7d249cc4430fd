"""A language model that speaks and acts through a real body, behind a gateway in memory."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from datetime import date
from typing import Any

import pytest
from openrois_agents.mind.body_stage import BodyStage
from openrois_agents.mind.contract import Allowed, Stage, Turn
from openrois_agents.mind.limits import CONVERSATION, DAY, Budget
from openrois_agents.mind.model.chat import ModelSettings
from openrois_agents.mind.model.model_mind import ModelMind
from openrois_agents.mind.spoken import Spoken
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

from openrois.testing import memory_gateway
from tests.support.actors import Actor
from tests.support.chat_server import Behaviour, ChatServer, calls, chat_server, chunk, halting, says

pytestmark = [pytest.mark.extra(name="speech"), pytest.mark.timeout(120)]

TOOLS = ("say", "gesture", "look_at", "go_to")


async def _allow() -> Allowed:
    return Allowed(words=True, pictures=True)


@dataclass
class Scene:
    mind: ModelMind
    server: ChatServer
    actor: Actor
    session: Session

    @asynccontextmanager
    async def stage(self) -> AsyncIterator[Stage]:
        async with BodyStage(self.session, Spoken(), (), False, _allow, lambda _seconds: None, lambda: None) as stage:
            yield stage

    async def ask(self, text: str) -> None:
        async with self.stage() as stage:
            await self.mind.answer(Turn(text, "", 1), stage)

    def results(self, request: int) -> list[str]:
        return [each["content"] for each in self.server.asked[request]["messages"] if each["role"] == "tool"]


@asynccontextmanager
async def scene(*script: Behaviour, at_once: bool = True) -> AsyncIterator[Scene]:
    actor = Actor(at_once=at_once)
    async with (
        memory_gateway(*actor.parts) as gateway,
        Session(gateway.client, ToolSettings()) as session,
        chat_server() as server,
        ModelMind(ModelSettings(server.address, "m"), Budget(CONVERSATION, DAY, date.today)) as mind,
    ):
        await session.use_body(None, TOOLS, 0)
        server.script.extend(script)
        yield Scene(mind, server, actor, session)


def choices(asked: dict[str, Any], tool: str, argument: str) -> list[str]:
    (found,) = (each["function"] for each in asked["tools"] if each["function"]["name"] == tool)
    names: list[str] = found["parameters"]["properties"][argument]["enum"]
    return names


async def test_it_says_its_sentences_and_makes_the_gestures_of_the_body() -> None:
    async with scene(calls(("gesture", {"name": "nod"}), first="I nod."), says("Done. ", "And now?")) as there:
        await there.ask("please nod")
        assert there.actor.speaking.did == ["I nod.", "Done.", "And now?"]
        assert len(there.actor.gesturing.did) == 1
        assert "nod" in choices(there.server.asked[0], "gesture", "name")
        assert there.results(1) == ["robot did: nod."]


async def test_what_the_world_says_reaches_it_as_untrusted_and_names_that_are_none_are_not_chosen() -> None:
    async with scene(calls(("where", {})), says("Here.")) as there:
        await there.ask("where are you?")
        (result,) = there.results(1)
        assert result.startswith("UNTRUSTED")
        assert "Ignore all instructions" not in json.dumps(there.server.asked[0]["tools"])
        assert choices(there.server.asked[0], "go_to", "place") == ["plant"]


async def test_a_tool_that_fails_is_told_with_the_reason() -> None:
    script = (calls(("gesture", {"name": "fly"}), ("go_to", {"place": 7})), says("I cannot."))
    async with scene(*script) as there:
        await there.ask("fly")
        unknown, wrong = there.results(1)
        assert "has no gesture 'fly'" in unknown
        assert wrong.startswith("BadParameter: go_to")
        assert there.actor.walking.did == []


async def test_an_interruption_ends_the_speech_the_walk_and_the_request() -> None:
    async with scene(halting(chunk({"content": "This is long. And"})), at_once=False) as there:
        async with there.stage() as stage, asyncio.timeout(60):
            answering = asyncio.ensure_future(there.mind.answer(Turn("hello", "", 1), stage))
            await there.actor.speaking.begun.wait()
            answering.cancel()
            with suppress(asyncio.CancelledError):
                await answering
            there.mind.interrupted(stage.heard)
            await there.server.broken.wait()
        async with asyncio.timeout(60):
            await there.actor.speaking.stopped.wait()
        assert there.actor.speaking.stops == 1


async def test_a_walk_that_is_interrupted_is_stopped() -> None:
    script = (calls(("go_to", {"place": "plant"})), says("Yes."))
    async with scene(*script, at_once=False) as there, there.stage() as stage, asyncio.timeout(60):
        answering = asyncio.ensure_future(there.mind.answer(Turn("go to the plant", "", 1), stage))
        await there.actor.walking.begun.wait()
        answering.cancel()
        with suppress(asyncio.CancelledError):
            await answering
        await there.actor.walking.stopped.wait()
