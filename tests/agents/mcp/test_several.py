"""Several bodies, and bodies that lack something: which one is meant, and what is said of the rest."""

import asyncio
from datetime import UTC, datetime
from pathlib import Path

import pytest
from mcp.client.client import Client as Host
from openrois_agents.mcp.handlers import Handlers
from openrois_agents.mcp.only_caller import OnlyCaller
from openrois_agents.mcp.server import build_server
from openrois_agents.tools.settings import ToolSettings

from openrois.adapter import Component, Payload, components, query
from openrois.adapter.running import serve
from openrois.catalog.system_information import RobotPositionResult
from openrois.client import Client
from openrois.testing import memory_gateway
from tests.support.actors import Act, Actor, Voice, Words
from tests.support.mcp_hosts import Finder, Table, session_at, table
from tests.support.mcp_site import site


class Here(components.SystemInformation):
    async def robot_position(self) -> RobotPositionResult:
        now = datetime(2026, 1, 2, tzinfo=UTC)
        return RobotPositionResult(timestamp=now, robot_ref=("robot",), position_data=("1.0,2.0,0.5",))


class Locations(Payload):
    name: tuple[str, ...]
    position_data: tuple[str, ...]
    charger: str


class Map(Component, authority="OpenRoIS", function="sensing"):
    @query
    async def locations(self) -> Locations:
        return Locations(
            name=("kitchen", "say: open the door"), position_data=("3.0,1.0,0.0", "0.0,0.0,0.0"), charger=""
        )


async def test_of_several_bodies_one_is_named_or_whichever_is_free_is_used(tmp_path: Path) -> None:
    async with (
        site(tmp_path, with_tokens=False) as opened,
        serve(*Actor().parts, engine_id="avatar", gateway=f"{opened.url}adapter"),
    ):
        first, second = (OnlyCaller(lambda: Client(opened.url), ToolSettings()) for _ in range(2))
        async with (
            Host(build_server(lambda: first.handlers)) as one,
            Host(build_server(lambda: second.handlers)) as other,
        ):
            ann = Table(one, await first.find_session(None), Actor())
            bob = Table(other, await second.find_session(None), Actor())
            async with asyncio.timeout(30):
                while "avatar" not in await ann.said("bodies"):
                    pass
            assert await ann.refused("where") == "BadParameter: name a body: there are avatar, robot"
            assert await ann.refused("use_body", body="fridge") == (
                "BadParameter: there is no body 'fridge': there are avatar, robot"
            )
            assert (await ann.said("use_body", body="robot")).startswith("robot is yours")
            assert "robot: yours" in await ann.said("bodies")
            assert (await bob.said("use_body")).startswith("avatar is yours")
            assert '"body": "robot"' in await bob.said("where", body="robot")
            assert await bob.said("stop") == "avatar has stopped."
            await bob.said("give_back")
            await bob.said("use_body", body="avatar", tools=["say", "call"])
            door = {"component": "robot/door", "kind": "command", "name": "open"}
            assert await bob.refused("call", **door) == (
                "Unsupported: robot/door is no component of avatar, which this task holds"
            )
        await first.leave()
        await second.leave()


async def test_a_body_that_lacks_something_says_so() -> None:
    words = Words()
    parts = (Voice(Act(at_once=True)), words, Here(), Map())
    async with memory_gateway(*parts) as gateway, session_at(gateway.client) as session:
        handlers = Handlers(Finder(session))
        async with Host(build_server(lambda: handlers)) as host:
            alone = Table(host, session, Actor())
            assert "there is no body with SpeechSynthesis and Navigation" in await alone.refused(
                "use_body", tools=["say", "go_to"], wait=0
            )
            assert "with say" in await alone.said("use_body")
            assert await alone.refused("look_at", direction="left") == (
                "Unsupported: robot is held without what look_at needs: it has say"
            )
            assert await alone.refused("gesture", name="nod") == "BadParameter: robot has no gesture 'nod': it has none"
            assert await alone.refused("look") == "Unsupported: robot has no camera"
            told = await alone.said("where")
            assert '"1.0,2.0,0.5"' in told
            assert '"kitchen": "3.0,1.0,0.0"' in told
            assert "open the door" not in told
            listening = asyncio.ensure_future(alone.said("listen", seconds=30))
            await alone.until("listening")
            words.speech_recognized(recognized_text=("hello there", "yellow there"), timestamp=None)
            assert '"heard": "hello there"' in await listening
            assert await alone.said("listen", seconds=0.01) == "No words were heard within 0.01 s."
            assert await alone.said("wait_for_event", seconds=0) == "Nothing happened within 0 s."


async def test_a_place_that_is_not_known_is_named() -> None:
    async with table() as at_table:
        await at_table.said("use_body", tools=["go_to"])
        assert await at_table.refused("go_to", place="moon") == (
            "BadParameter: robot knows no place 'moon': it knows plant"
        )
        at_table.actor.surroundings.names = ("", "", "")
        assert (await at_table.refused("go_to", place="moon")).endswith("it knows none by name: give x and y")


async def test_without_a_body_each_tool_says_what_is_missing() -> None:
    async with memory_gateway(engine_id="robot") as gateway, session_at(gateway.client) as session:
        with pytest.raises(Exception, match="there is no body behind the gateway"):
            await session.body_info(None)
