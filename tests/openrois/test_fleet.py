"""A fleet of robots that have every basic component: they work, and their profiles fit the limits of the wire."""

import asyncio

import pytest

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.contract import Event, SubscriptionLost
from openrois.errors import Aborted, BadParameter, ComponentFailed, Unsupported
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument
from tests.support.deployment import application, gateway, until
from tests.support.fleet import Robot, everything, fleet


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


def robots(count: int) -> tuple[Robot, ...]:
    return tuple(everything(f"robot_{number}") for number in range(1, count + 1))


async def test_robots_behind_a_gateway() -> None:
    pair = robots(2)
    async with gateway() as main, fleet(main.url.replace("http", "ws") + "adapter", *pair):
        await until(main.engine, lambda ids: set(ids) >= {"robot_1", "robot_2"})
        async with application(main) as app:
            profile = await app.ask("rois.system.get_profile")
            assert len(profile["component_profiles"]) == 34
            asked = await app.ask(
                "rois.query.query", query_type="engine_status", condition="component_ref LIKE 'robot_2/%'"
            )
            assert [each["name"] for each in asked["results"]] == ["status", "operable_time"]
