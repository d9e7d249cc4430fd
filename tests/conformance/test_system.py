"""The System interface: connect, disconnect, get_profile, profile_changed."""

from contextlib import AsyncExitStack

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.components import Lamp
from tests.support.deployment import Adapter, Application

TYPE = "component_type = 'urn:x-rois:def:component:Test::Lamp'"


async def test_connect_sets_up_nothing_that_is_needed(app: Application) -> None:
    assert await app.code("rois.command.search") == "OK"
    assert await app.ask("rois.system.connect") == {"return_code": "OK"}
    assert await app.ask("rois.system.connect") == {"return_code": "OK"}


async def test_the_profile_is_the_tree_with_references_unchanged(app: Application) -> None:
    result = await app.ask("rois.system.get_profile")
    assert result["return_code"] == "OK"
    assert result["profile"]["identifier"]["code"] == "gateway"
    assert result["profile"]["component_ids"] == []
    (robot,) = result["profile"]["sub_profiles"]
    assert robot["identifier"]["code"] == "robot"
    assert robot["component_ids"] == ["robot/lamp", "robot/bell", "robot/door", "robot/camera"]
    assert list(result["component_profiles"]) == robot["component_ids"]
    lamp = result["component_profiles"]["robot/lamp"]
    assert (lamp["name"], lamp["function"]) == ("lamp", "actuation")
    assert result["component_profiles"]["robot/door"]["function"] is None


async def test_a_condition_keeps_the_engines_and_chooses_components(app: Application) -> None:
    result = await app.ask("rois.system.get_profile", condition=TYPE)
    assert result["profile"]["sub_profiles"][0]["component_ids"] == ["robot/lamp"]
    assert list(result["component_profiles"]) == ["robot/lamp"]
    nothing = await app.ask("rois.system.get_profile", condition="component_ref = 'x'")
    assert nothing["component_profiles"] == {}
    assert nothing["profile"]["sub_profiles"][0]["component_ids"] == []


async def test_a_condition_that_cannot_be_read(app: Application) -> None:
    for condition in ("component_ref", "colour = 'red'", "stream_id = 'x'", "component_ref = 'x' OR 1"):
        assert await app.ask("rois.system.get_profile", condition=condition) == {
            "return_code": "BAD_PARAMETER",
            "profile": None,
            "component_profiles": {},
        }


async def test_disconnect_gives_everything_back_and_leaves_the_socket_open(
    app: Application, other: Application, robot: deployment.Robot
) -> None:
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    assert await app.code("rois.event.subscribe", event_type="rang") == "OK"
    assert await app.ask("rois.system.disconnect") == {"return_code": "OK"}
    assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    robot.bell.ring("nobody hears it")
    assert await app.settled() == []
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OUT_OF_RESOURCES"


async def test_what_is_asked_right_behind_disconnect_stands(app: Application, robot: deployment.Robot) -> None:
    await app.ask("rois.event.subscribe", event_type="rang")
    leaving = await app.begin("rois.system.disconnect")
    of_streams = "component_ref = 'robot/camera'"
    asked = [
        await app.begin("rois.system.connect"),
        await app.begin("rois.command.bind", component_ref="robot/lamp"),
        await app.begin("rois.event.subscribe", event_type="notify_stream_status", condition=of_streams),
        await app.begin("rois.event.subscribe", event_type="rang"),
    ]
    answers = [(await app.answer(request_id))["result"] for request_id in (leaving, *asked)]
    assert [answer["return_code"] for answer in answers] == ["OK"] * 5
    robot.bell.ring("ding")
    assert (await app.next("rois.event.notify_event"))["subscribe_id"] == answers[4]["subscribe_id"]
    await app.ask("rois.stream.connect_stream", component_ref="robot/camera")
    assert (await app.next("rois.event.notify_event"))["subscribe_id"] == answers[3]["subscribe_id"]


async def test_every_session_hears_that_the_tree_changed(
    app: Application, other: Application, gateway: Gateway, stack: AsyncExitStack
) -> None:
    second = await stack.enter_async_context(deployment.adapter(gateway, Lamp(), engine_id="second"))
    for session in (app, other):
        assert await session.next("rois.system.profile_changed") == {}
    assert (await app.ask("rois.command.search", condition=TYPE))["component_ref_list"] == [
        "robot/lamp",
        "second/lamp",
    ]
    await second.stop()
    for session in (app, other):
        assert await session.next("rois.system.profile_changed") == {}
    assert (await app.ask("rois.command.search", condition=TYPE))["component_ref_list"] == ["robot/lamp"]


async def test_an_adapter_that_changes_is_read_again(app: Application, adapter: Adapter, stack: AsyncExitStack) -> None:
    """Behind the adapter a further engine appears and goes."""
    below = await stack.enter_async_context(deployment.two_level(adapter, Lamp(), engine_id="below"))
    await app.next("rois.system.profile_changed")
    refs = (await app.ask("rois.command.search", condition="component_ref LIKE 'below/%'"))["component_ref_list"]
    assert refs == ["below/lamp"]
    adapter.host.engine.detach(below)
    await app.next("rois.system.profile_changed")
    assert await app.code("rois.command.bind", component_ref="below/lamp") == "UNSUPPORTED"
