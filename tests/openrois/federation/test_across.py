"""An adapter at one gateway, applications at others: what is asked and notified passes between them."""

from collections.abc import AsyncIterator

import pytest

from tests.support.cluster import seen_by
from tests.support.deployment import Robot, patience
from tests.support.nats import NatsServer
from tests.support.place import Place, place_of, unit
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")


@pytest.fixture
async def place(shared_nats: NatsServer, postgres_server: Server) -> AsyncIterator[Place]:
    async with place_of(shared_nats, postgres_server, "a", "b") as here:
        await here.attach("a")
        yield here


async def test_a_command_runs_and_its_results_come_back(place: Place) -> None:
    app = await place.app()
    assert await app.code("rois.command.bind", component_ref="robot/door") == "OK"
    opening = unit("robot/door", "open", how="wide")
    assert await app.code("rois.command.execute", command_unit_list=[opening]) == "OK"
    assert await app.completed("1") == {"1": "OK"}
    answer = await app.ask("rois.command.get_command_result", command_id="1", condition="")
    assert [result["value"] for result in answer["results"]] == ["wide"]
    assert await app.code("rois.command.execute", command_unit_list=[opening]) == "BAD_PARAMETER"


async def test_refusals_come_with_their_reasons(place: Place) -> None:
    app, other = await place.app("b"), await place.app("a")
    assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    code, why = await app.why("rois.command.bind", component_ref="robot/lamp")
    assert (code, why) == ("OUT_OF_RESOURCES", "robot/lamp is bound by another application")
    code, why = await app.why("rois.command.bind", component_ref="robot/nothing")
    assert (code, why) == ("UNSUPPORTED", "there is no component 'robot/nothing'")
    error = await app.refused("rois.command.bind", component_ref=7)
    assert error["code"] == -32602


async def test_any_component_that_is_free_is_bound_at_whichever_gateway(place: Place) -> None:
    second = Robot()
    await place.attach("b", "second", second)
    app, other = await place.app("b"), await place.app("a")
    await seen_by(other, "robot", "second")
    condition = "component_ref LIKE '%/lamp'"
    bound = [(await each.ask("rois.command.bind_any", condition=condition))["component_ref"] for each in (app, other)]
    assert sorted(bound) == ["robot/lamp", "second/lamp"]
    third = await place.app("b")
    assert await third.code("rois.command.bind_any", condition=condition) == "OUT_OF_RESOURCES"


async def test_one_sequence_commands_bodies_of_one_gateway(place: Place) -> None:
    second = Robot()
    await place.attach("b", "second", second)
    app = await place.app("b")
    await seen_by(app, "second")
    for ref in ("robot/door", "second/door"):
        assert await app.code("rois.command.bind", component_ref=ref) == "OK"
    units = [unit("robot/door", "open", "1"), unit("second/door", "open", "2")]
    code, why = await app.why("rois.command.execute", command_unit_list=units)
    assert (code, why) == ("BAD_PARAMETER", "robot, second are at different gateways: send a sequence to each of them")
    for each in units:
        assert await app.code("rois.command.execute", command_unit_list=[each]) == "OK"
    assert await app.completed("1", "2") == {"1": "OK", "2": "OK"}


async def test_events_come_behind_the_reply_that_begins_them(place: Place) -> None:
    app = await place.app()
    answer = await app.ask("rois.event.subscribe", event_type="rang", condition="component_ref = 'robot/bell'")
    assert answer["return_code"] == "OK"
    assert answer["subscribe_id"].startswith("robot/")
    place.robot.bell.ring("la")
    told = await app.next("rois.event.notify_event")
    assert told["subscribe_id"] == answer["subscribe_id"]
    detail = await app.ask("rois.event.get_event_detail", event_id=told["event_id"], condition="")
    assert detail["return_code"] == "OK"
    assert await app.code("rois.event.unsubscribe", subscribe_id=answer["subscribe_id"]) == "OK"


async def test_a_component_is_handed_over_between_gateways(place: Place) -> None:
    holder, asker = await place.app("a"), await place.app("b")
    assert await holder.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    asked = await asker.ask("openrois.lease.request", component_ref="robot/lamp")
    assert asked["lease"]["state"] == "HELD"
    told = await holder.next("openrois.lease.requested")
    assert await holder.code("openrois.lease.grant", request_id=told["request_id"]) == "OK"
    async with patience():
        while (await asker.next("openrois.lease.changed"))["state"] != "MINE":
            pass
    back = await holder.ask("openrois.lease.request", component_ref="robot/lamp")
    assert back["lease"]["state"] == "HELD"
    told = await asker.next("openrois.lease.requested")
    assert await asker.code("openrois.lease.decline", request_id=told["request_id"]) == "OK"
    assert (await holder.next("openrois.lease.declined"))["reason"] == "its holder keeps it"


async def test_everything_is_stopped_by_the_link(place: Place) -> None:
    app = await place.app("b")
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    assert await app.code("rois.command.execute", command_unit_list=[unit("robot/lamp", "start")]) == "OK"
    await place.robot.lamp.glowing.wait()
    assert (await app.ask("openrois.stop_all", engine_id="robot"))["stopped"] == ["robot/lamp"]
    assert await app.completed("1") == {"1": "ABORT"}


async def test_everything_is_stopped_wherever_it_is(place: Place) -> None:
    second = Robot()
    await place.attach("b", "second", second)
    app = await place.app("b")
    await seen_by(app, "second")
    for number, (ref, lamp) in enumerate((("robot/lamp", place.robot.lamp), ("second/lamp", second.lamp))):
        assert await app.code("rois.command.bind", component_ref=ref) == "OK"
        assert await app.code("rois.command.execute", command_unit_list=[unit(ref, "start", str(number))]) == "OK"
        await lamp.glowing.wait()
    answer = await app.ask("openrois.stop_all")
    assert sorted(answer["stopped"]) == ["robot/lamp", "second/lamp"]
    assert await app.completed("0", "1") == {"0": "ABORT", "1": "ABORT"}


async def test_a_disconnected_application_holds_nothing_elsewhere(place: Place) -> None:
    app, other = await place.app("b"), await place.app("a")
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    assert await app.code("rois.system.disconnect") == "OK"
    assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OK"


async def test_an_engine_that_leaves_is_seen_to_leave(place: Place) -> None:
    gone = await place.attach("a", "second", Robot())
    app = await place.app("b")
    await seen_by(app, "second")
    await gone.stop()
    await seen_by(app, "second", absent=True)
    assert await app.code("rois.command.bind", component_ref="second/lamp") == "UNSUPPORTED"
