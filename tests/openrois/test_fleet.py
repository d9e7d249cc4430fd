"""A fleet of robots that have every basic component: they work, and their profiles fit the limits of the wire."""

import asyncio
import json
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.catalog.actuation import NAVIGATION
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.contract import Event, SubscriptionLost
from openrois.engine.engine import Engine
from openrois.errors import Aborted, BadParameter, ComponentFailed, Unsupported
from openrois.gateway.server import Gateway
from openrois.gateway.socket import ADAPTER
from openrois.session.session import EngineHost
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument
from tests.support.deployment import gateway, until
from tests.support.fleet import everything, fleet


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="", value=value)


class TestARobot:
    @pytest.mark.parametrize("kind", BASIC_COMPONENTS, ids=lambda kind: kind.code)
    async def test_every_query_is_answered_as_its_type_says(self, kind: object) -> None:
        robot = everything()
        part = next(part for part in robot.parts.values() if part.kind is kind)
        for query in part.kind.all_queries():
            query.results.from_results(await part.ask(query.name))

    @pytest.mark.parametrize("kind", BASIC_COMPONENTS, ids=lambda kind: kind.code)
    async def test_every_event_is_heard(self, kind: object) -> None:
        robot = everything()
        part = next(part for part in robot.parts.values() if part.kind is kind)
        heard: list[Event | SubscriptionLost] = []
        for event in part.kind.all_events():
            await robot.registry.subscribe(robot.ref(part.kind.code), event.name, heard.append)
            told = part.tell(event.name)
            last = heard[-1]
            assert isinstance(last, Event)
            assert event.results.from_results(last.results) == told
        assert len(heard) == len(part.kind.all_events())

    async def test_a_robot_arrives_where_it_was_sent(self) -> None:
        robot = everything()
        heard: list[Event | SubscriptionLost] = []
        ref = robot.ref("Navigation")
        assert ref == "robot/navigation"
        await robot.registry.subscribe(ref, "reached_target", heard.append)
        await robot.registry.invoke(ref, "set_parameter", (argument("target_positions", '["lobby", "door"]'),))
        await robot.registry.invoke(ref, "start")
        told = [[each.value for each in event.results] for event in heard if isinstance(event, Event)]
        assert told == [["lobby", "false"], ["door", "true"]]
        parameters = {each.name: each.value for each in await robot.registry.query(ref, "get_parameter")}
        assert parameters == {"target_positions": '["lobby", "door"]', "time_limit": "0", "routing_policy": "time"}

    async def test_a_robot_that_follows_is_stopped(self) -> None:
        robot = everything()
        follow = robot.parts["Follow"]

        async def stop() -> None:
            await follow.following.wait()
            assert follow.status is ComponentStatus.BUSY
            await follow.run("stop", ())

        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(stop())
            with pytest.raises(Aborted):
                await follow.run("start", ())
        assert follow.status is ComponentStatus.READY

    async def test_streams_come_and_go(self) -> None:
        robot = everything()
        camera = robot.parts["VideoStreaming"]
        (connected,) = await camera.run("connect_stream", ())
        for verb, status in (("suspend", "SUSPENDED"), ("resume", "RUNNING"), ("disconnect", "NOT_CONNECTED")):
            await camera.run(f"{verb}_stream", (argument("stream_id", connected.value),))
            assert [each.value for each in await camera.ask("get_stream_status")] == [f"STREAMING_{status}"]
        with pytest.raises(BadParameter, match="there is no stream"):
            await camera.run("suspend_stream", (argument("stream_id", connected.value),))

    async def test_what_it_refuses(self) -> None:
        navigation = everything().parts["Navigation"]
        with pytest.raises(Unsupported):
            await navigation.ask("weather")
        with pytest.raises(Unsupported):
            await navigation.run("fly", ())
        with pytest.raises(BadParameter):
            await navigation.run("set_parameter", (argument("time_limit", "soon"),))
        with pytest.raises(BadParameter):
            await navigation.run("start", (argument("where", "there"),))
        navigation.is_in = ComponentStatus.ERROR
        with pytest.raises(ComponentFailed):
            await navigation.run("start", ())
        assert [each.value for each in await navigation.ask("component_status")] == ["ERROR"]


class TestTwentyRobots:
    """Each with all seventeen components; 340 component profiles travel in one message."""

    async def test_an_application_gets_all_profiles(self) -> None:
        robots = [everything(f"avatar_{number}") for number in range(1, 21)]
        async with gateway() as main, fleet(f"{address(main)}adapter", *robots):
            await until(main.engine, lambda ids: len(ids) == 21)
            # The library takes a mebibyte at most, unless it is told otherwise: so do other people's applications.
            async with connect(address(main)) as socket:
                size, result = await asked(socket, "rois.system.get_profile")
                assert len(result["component_profiles"]) == 340
                assert result["component_profiles"]["avatar_20/navigation"] == NAVIGATION.profile().model_dump(
                    mode="json"
                )
                assert size < ADAPTER.max_message
                # What is found among all of them still answers.
                condition = "component_ref LIKE 'avatar_20/%'"
                _, found = await asked(socket, "rois.query.query", query_type="engine_status", condition=condition)
                assert found["return_code"] == "OK"
                _, found = await asked(socket, "rois.command.search", condition=f"component_type = '{NAVIGATION.urn}'")
                assert len(found["component_ref_list"]) == 20

    async def test_a_parent_gateway_takes_them_from_one_below(self) -> None:
        site = Engine("site")
        for number in range(1, 21):
            await site.attach(await everything(f"avatar_{number}").engine())
        async with gateway() as parent, TaskScope() as tasks:
            dialling = asyncio.ensure_future(serve_parent(EngineHost(site, tasks), f"{address(parent)}adapter"))
            await until(parent.engine, lambda ids: len(ids) == 22)
            assert parent.engine.directory.component_profiles == site.directory.component_profiles
            async with connect(address(parent)) as socket:
                size, result = await asked(socket, "rois.system.get_profile")
            assert len(result["component_profiles"]) == 340
            # What the parent was told has fewer bytes than what it tells itself.
            assert size < ADAPTER.max_message
            dialling.cancel()
            await asyncio.wait({dialling})


def address(main: Gateway) -> str:
    return main.url.replace("http", "ws")


async def asked(socket: ClientConnection, method: str, **params: str) -> tuple[int, dict[str, Any]]:
    """Ask and return how many bytes the answer has, and its result."""
    await socket.send(json.dumps({"jsonrpc": "2.0", "id": method, "method": method, "params": params}))
    while True:
        text = await socket.recv()
        message = json.loads(text)
        if message.get("id") == method:
            return len(text.encode() if isinstance(text, str) else text), message["result"]
