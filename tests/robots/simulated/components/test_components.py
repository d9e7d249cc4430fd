"""The simulated robot's components, behind a gateway in memory."""

import asyncio
import json
from collections.abc import AsyncIterator
from math import dist, hypot, pi

import pytest
from openrois_body.teleoperation.pilot import PATIENCE
from openrois_robots.simulated.world.plan import APARTMENT

from openrois.client import Fault
from openrois.client.components import Follow, Move, Navigation, SystemInformation
from openrois.contract import Client as Application
from openrois.errors import Aborted, BadParameter, ComponentFailed
from openrois.types.codes import ErrorType
from openrois.types.streams import HolderNotification
from tests.support.simulated_robot import Stage, at, staged
from tests.support.streaming import settle
from tests.support.teleoperation import Hand

pytestmark = pytest.mark.extra(name="robot")


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    async with staged() as made:
        yield made


async def navigate(stage: Stage, *targets: str) -> None:
    navigation = await stage.client.find(Navigation)
    async with navigation.bound():
        await navigation.set(target_positions=list(targets))
        await stage.until(stage.client.run(navigation.start()))


class TestNavigation:
    async def test_it_drives_through_the_rooms_and_reports_its_way(self, stage: Stage) -> None:
        navigation = await stage.client.find(Navigation)
        places: list[str] = []
        surroundings = stage.client.component("robot/surroundings")
        async with surroundings.event("figure_moved") as moved, navigation.reached_target() as reached:
            await navigate(stage, "-1.5,0", "2.5,1.0,1.57")
            await settle()
            assert [each.target for each in (await anext(aiter(reached)), await anext(aiter(reached)))] == [
                "-1.5,0",
                "2.5,1.0,1.57",
            ]
            places.append((await anext(aiter(moved)))["position_data"])
        assert places
        assert dist((stage.place.x, stage.place.y), (2.5, 1.0)) < 0.05
        assert stage.place.th == pytest.approx(pi / 2, abs=0.05)

    async def test_it_drives_to_a_person_and_looks_at_it(self, stage: Stage) -> None:
        await navigate(stage, "reader")
        reader = APARTMENT.persons[0].place
        assert dist((stage.place.x, stage.place.y), (reader.x, reader.y)) < 0.85

    @pytest.mark.parametrize(
        ("target", "why"),
        [
            ("-2.9,1.6", "'-2.9,1.6' is outside of the floor or inside an obstacle"),
            ("20,0", "'20,0' is outside of the floor or inside an obstacle"),
            ("-2.9,0.9", r"'-2.9,0.9' is only 0.10 m from an edge; the body needs 0.25 m"),
            ("3,-3.4", "from an edge"),
            ("garden", "'garden' is not in the scene; there is 'reader', 'cook'"),
        ],
    )
    async def test_it_refuses_with_a_reason(self, stage: Stage, target: str, why: str) -> None:
        with pytest.raises((BadParameter, ComponentFailed), match=why.replace(".", r"\.")):
            await navigate(stage, target)
        assert dist((stage.place.x, stage.place.y), (-4, -2.5)) < 0.01, "it has not moved"

    async def test_a_way_that_is_blocked_ends_with_how_far_it_was(self) -> None:
        async with staged(at(3.0, -1.2)) as stage:
            with pytest.raises(ComponentFailed, match=r"stuck 0\.\d\d m before the goal"):
                await navigate(stage, "4.6,-3.0")

    async def test_stop_ends_it_and_it_stands(self, stage: Stage) -> None:
        driving = asyncio.ensure_future(navigate(stage, "2.5,1.0"))
        await stage.until(asyncio.sleep(0))
        while stage.place.x < -3.5:
            await stage.run(0.1)
        assert await stage.client.control.stop_all()
        with pytest.raises(Aborted):
            await driving
        await stage.run(0.5)
        there = stage.place
        await stage.run(2)
        assert stage.place == there


class TestBattery:
    async def test_a_low_battery_refuses_all_but_the_dock(self) -> None:
        async with staged(at(-1.6, -1.6), charge=0.15) as stage:
            information = await stage.client.find(SystemInformation)
            assert await information.query("battery") == {"percent": 15, "is_charging": False, "is_low": True}
            assert (await information.engine_status()).status.value == "WARNING"
            reason = "the battery is at 15 %; below 20 % only the dock is a goal"
            for targets in (["-1.5,0"], ["reader"], ["-1.5,0", "dock"]):
                with pytest.raises(ComponentFailed, match=reason):
                    await navigate(stage, *targets)
            move = await stage.client.find(Move)
            async with move.bound():
                await move.set(line=[500, 0])
                with pytest.raises(ComponentFailed, match=reason):
                    await stage.until(stage.client.run(move.start()))
            assert dist((stage.place.x, stage.place.y), (-1.6, -1.6)) < 0.01
            await navigate(stage, "dock")
            assert (await information.query("battery"))["is_charging"]

    async def test_an_empty_battery_is_an_error_until_it_is_charged(self) -> None:
        async with staged(at(-1.6, -1.6), charge=0.0, charging=5) as stage:
            information = await stage.client.find(SystemInformation)
            assert (await information.engine_status()).status.value == "ERROR"
            with pytest.raises(ComponentFailed, match="navigation does not work now \\(ERROR\\)"):
                await navigate(stage, "dock")
            dock = stage.client.component("robot/dock")
            async with dock.event("battery_changed") as changed, dock.bound():
                await stage.until(dock.command("push"))
                assert (await stage.until(anext(aiter(changed))))["is_charging"]
            await stage.run(90)
            assert (await information.engine_status()).status.value == "READY"
            await navigate(stage, "-3.0,-1.0")

    async def test_an_application_that_holds_it_is_told_when_the_battery_is_used_up(self) -> None:
        async with staged(at(-1.6, -1.6), charge=0.01, low=0.0, standing=5, driving=5) as stage:
            navigation = await stage.client.find(Navigation)
            async with navigation.bound(), stage.client.notices(Fault) as faults:
                await navigation.set(target_positions=["-1.6,2.6"])
                with pytest.raises(ComponentFailed, match="the battery is empty"):
                    await stage.until(stage.client.run(navigation.start()))
                fault = await stage.until(anext(aiter(faults)))
                assert fault.error_type is ErrorType.COMPONENT_INTERNAL_ERROR


class TestFollow:
    async def test_it_follows_a_visitor(self) -> None:
        async with staged(visitor=True) as stage:
            follow = await stage.client.find(Follow)
            async with follow.bound():
                await follow.set(target_object_ref="visitor", distance=1000)
                following = asyncio.ensure_future(stage.client.run(follow.start()))
                far = []
                for _ in range(40):
                    await stage.run(1)
                    assert not following.done()
                    visitor = stage.robot.simulation.view().visitor
                    assert visitor is not None
                    far.append(hypot(visitor.x - stage.place.x, visitor.y - stage.place.y))
                assert max(far[15:]) < 2.2
                assert min(far) > 0.45
                await stage.until(stage.client.run(follow.stop()))
                with pytest.raises(Aborted):
                    await following


class TestTeleoperation:
    async def test_it_is_driven_by_hand_and_stands_when_messages_stay_away(self, stage: Stage) -> None:
        teleoperation = stage.client.component("robot/teleoperation")
        operator = stage.robot.operator_control
        application = Application("1", lambda _method, _params: None)
        operator.apply_holder(HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1), application)
        told: list[str] = []
        sink, hand = operator.input_sink(application, told.append), Hand()
        async with teleoperation.bound(), teleoperation.event("stopped") as stopped:
            operating = asyncio.ensure_future(stage.client.run(teleoperation.command("start")))
            await stage.run(0.5)
            for _ in range(20):
                sink.input_came("input", json.dumps(hand.state().to_json()))
                await stage.run(0.1)
            driven = stage.place
            assert dist((driven.x, driven.y), (-4, -2.5)) > 0.8
            await stage.run(PATIENCE + 0.5)
            there = stage.place
            assert dist((driven.x, driven.y), (there.x, there.y)) < 0.55
            await stage.run(1)
            assert stage.place == there
            assert (await stage.until(anext(aiter(stopped))))["reason"] == "no input came for 0.4 s"
            operator.forget_client(application)
            with pytest.raises(Aborted, match="the application that operated is gone"):
                await stage.until(operating)

    async def test_an_application_that_leaves_leaves_a_robot_that_stands(self, stage: Stage) -> None:
        operator = stage.robot.operator_control
        application = Application("1", lambda _method, _params: None)
        operator.apply_holder(HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1), application)
        sink, hand = operator.input_sink(application, lambda _text: None), Hand()
        teleoperation = stage.client.component("robot/teleoperation")
        async with teleoperation.bound():
            operating = asyncio.ensure_future(stage.client.run(teleoperation.command("start")))
            await stage.run(0.5)
            for _ in range(10):
                sink.input_came("input", json.dumps(hand.state().to_json()))
                await stage.run(0.1)
            operator.forget_client(application)
            await stage.run(0.5)
            there = stage.place
            await stage.run(1)
            assert stage.place == there
            with pytest.raises(Aborted):
                await stage.until(operating)


async def test_a_hand_ends_navigation(stage: Stage) -> None:
    driving = asyncio.ensure_future(navigate(stage, "2.5,1.0"))
    await stage.run(2)
    operator = stage.robot.operator_control
    application = Application("1", lambda _method, _params: None)
    operator.apply_holder(HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1), application)
    teleoperation = stage.client.component("robot/teleoperation")
    async with teleoperation.bound():
        operating = asyncio.ensure_future(stage.client.run(teleoperation.command("start")))
        await stage.run(0.3)
        sink = operator.input_sink(application, lambda _text: None)
        sink.input_came("input", json.dumps(Hand().state().to_json()))
        with pytest.raises(Aborted, match="an operator drives the body by hand"):
            await stage.until(driving)
        operator.forget_client(application)
        with pytest.raises(Aborted):
            await stage.until(operating)


async def test_a_gaze_turns_the_camera(stage: Stage) -> None:
    gaze = stage.client.component("robot/gaze")
    ahead = stage.robot.simulation.view().camera.th
    async with gaze.bound():
        await stage.until(gaze.command("look", x=1.0, y=0.0))
    assert stage.robot.simulation.view().camera.th < ahead - 0.5
