"""An agent shares its body with persons: they take a part, give it back, and stop it, and the agent is told."""

import asyncio
from pathlib import Path

import pytest
from openrois_agents.mcp.only_caller import OnlyCaller
from openrois_agents.tools.settings import ToolSettings
from openrois_agents.tools.toolbox import call_tool

from openrois.client import Aborted, Client, ConnectionLost, OutOfResources
from openrois.testing import FaultRelay
from tests.support.actors import Actor
from tests.support.mcp_site import agent_token, site


async def _quietly(_seconds: float, _message: str) -> None:
    pass


async def test_a_person_takes_a_part_and_stops_the_body_and_the_agent_waits(tmp_path: Path) -> None:
    async with site(tmp_path) as opened:
        agent = OnlyCaller(lambda: Client(opened.url, token=agent_token("mind", rank="agent")), ToolSettings())
        session = await agent.find_session(None)

        async def call(tool: str, **arguments: object) -> str:
            return (await call_tool(session, tool, arguments, _quietly)).text

        await call("use_body", tools=["say", "go_to"])
        async with Client(opened.url, token=agent_token("ann", rank="person")) as person:
            await person.control.borrow("robot/speech_synthesizer")
            assert '"event": "part_taken_for_a_time"' in await call("wait_for_event", after=0, events=[], seconds=30)
            with pytest.raises(OutOfResources, match="was taken for a time by ann"):
                await call("say", text="x")
            await call("go_to", place="plant")
            await person.control.give_back("robot/speech_synthesizer")
            (back,) = await session.log.wait(0, ("part_came_back",), 30)
            assert back.source == "robot/speech_synthesizer"
            await call("say", text="I have it again.")

            await person.control.stop_all("robot")
            (stopped,) = await session.log.wait(0, ("stopped_by_a_person",), 30)
            assert stopped.data["by"] == "ann"
            with pytest.raises(OutOfResources, match="robot was stopped by ann: programs wait until a person hands it"):
                await call("say", text="x")
            await person.control.release_stop("robot")
            await session.log.wait(0, ("handed_back_by_a_person",), 30)
            await call("say", text="Thank you.")
        assert opened.actor.speaking.did == ["I have it again.", "Thank you."]
        await agent.leave()


async def test_a_body_that_is_lost_is_told_and_another_one_can_be_used(tmp_path: Path) -> None:
    async with site(tmp_path) as opened:
        agent = OnlyCaller(lambda: Client(opened.url, token=agent_token("mind", rank="agent")), ToolSettings())
        session = await agent.find_session(None)
        await call_tool(session, "use_body", {}, _quietly)
        async with Client(opened.url, token=agent_token("root", roles=["administrator"])) as administrator:
            await administrator.control.take("robot/speech_synthesizer")
            await session.log.wait(0, ("body_lost",), 30)
            with pytest.raises(OutOfResources, match=r"robot was lost: .*; use_body reserves a body again"):
                await call_tool(session, "say", {"text": "x"}, _quietly)
        assert (await call_tool(session, "use_body", {"wait": 30.0}, _quietly)).data["body"] == "robot"
        await agent.leave()


async def test_a_task_goes_on_when_the_connection_was_lost_and_what_moved_has_stopped(tmp_path: Path) -> None:
    actor = Actor(at_once=False)
    async with site(tmp_path, actor=actor) as opened, FaultRelay(opened.url) as relay:
        token = agent_token("mind", rank="agent")
        agent = OnlyCaller(lambda: Client(relay.url.replace("http", "ws", 1), token=token), ToolSettings())
        session = await agent.find_session(None)
        await call_tool(session, "use_body", {"tools": ["go_to", "say"]}, _quietly)
        going = asyncio.ensure_future(call_tool(session, "go_to", {"place": "plant"}, _quietly))
        await actor.walking.begun.wait()
        relay.cut()
        await actor.walking.stopped.wait()
        with pytest.raises((Aborted, ConnectionLost)):
            await going
        await session.log.wait(0, ("connection_restored",), 30)
        actor.speaking.may_end.set()
        assert (await call_tool(session, "say", {"text": "I am back."}, _quietly)).data == {"body": "robot"}
        await agent.leave()
        assert await opened.is_free(agent_token("bob"))
