"""The System interface: connect, disconnect, get_profile, profile_changed."""

from contextlib import AsyncExitStack

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.components import Lamp
from tests.support.deployment import Adapter, Application
from tests.support.plain import component_profile, engine_profile, plain_adapter, profile_result, refusal

TYPE = "component_type = 'urn:x-rois:def:component:Test::Lamp'"


async def test_connect_sets_up_nothing_that_is_needed(app: Application) -> None:
    assert await app.code("rois.command.search") == "OK"
    assert await app.ask("rois.system.connect") == {"return_code": "OK"}
    assert await app.ask("rois.system.connect") == {"return_code": "OK"}


async def test_the_profile_is_the_tree_with_references_unchanged(app: Application) -> None:
    result = await app.ask("rois.system.get_profile")
    assert result["return_code"] == "OK"
    assert result["profile"]["identifier"]["code"] == "gateway"
    assert result["profile"]["identifier"]["authority"] == "OpenRoIS"
    (robot,) = result["profile"]["sub_profiles"]
    assert robot["identifier"]["code"] == "robot"
    assert robot["component_ids"] == ["robot/lamp", "robot/bell", "robot/door", "robot/camera"]
    assert list(result["component_profiles"]) == robot["component_ids"] == result["profile"]["component_ids"]
    lamp = result["component_profiles"]["robot/lamp"]
    assert (lamp["name"], lamp["function"]) == ("lamp", "actuation")
    assert result["component_profiles"]["robot/door"]["function"] is None


async def test_every_level_lists_what_is_reachable_there(
    app: Application, gateway: Gateway, adapter: Adapter, stack: AsyncExitStack
) -> None:
    await stack.enter_async_context(deployment.two_level(adapter, Lamp(), engine_id="below"))
    await app.next("rois.system.profile_changed")
    profile = (await app.ask("rois.system.get_profile"))["profile"]
    (robot,) = profile["sub_profiles"]
    (below,) = robot["sub_profiles"]
    own = ["robot/lamp", "robot/bell", "robot/door", "robot/camera"]
    assert below["component_ids"] == ["below/lamp"]
    assert robot["component_ids"] == profile["component_ids"] == [*own, "below/lamp"]
    chosen = (await app.ask("rois.system.get_profile", condition="component_ref = 'robot/lamp'"))["profile"]
    assert [each["sub_profiles"] for each in chosen["sub_profiles"]] == [[]]


async def test_engines_that_list_what_stands_below_them_are_attached(gateway: Gateway, stack: AsyncExitStack) -> None:
    """As a gateway behind a gateway does; listed by two engines beside one another a component stands twice."""
    deep = engine_profile("deep", "deep/toy")
    listed = profile_result("toy")
    listed["component_profiles"]["deep/toy"] = component_profile("toy")
    listed["profile"] = engine_profile("plain", "plain/toy", "deep/toy", below=(deep,))
    await stack.enter_async_context(plain_adapter(gateway, listed))
    await deployment.until(gateway.engine, lambda ids: "deep" in ids)
    app = await stack.enter_async_context(deployment.application(gateway))
    assert (await app.ask("rois.command.search"))["component_ref_list"] == ["plain/toy", "deep/toy"]
    assert await app.code("rois.query.query", query_type="mood", condition="component_ref = 'deep/toy'") == "OK"
    twice = profile_result("toy", engine_id="other")
    beside = (engine_profile("a", "other/toy"), engine_profile("b", "other/toy"))
    twice["profile"] = engine_profile("other", below=beside)
    refused = await stack.enter_async_context(plain_adapter(gateway, twice))
    assert await refusal(refused) == (1008, "the component 'other/toy' cannot be in this tree: it stands twice")


async def test_a_condition_chooses_components_and_the_engines_that_have_them(app: Application) -> None:
    result = await app.ask("rois.system.get_profile", condition=TYPE)
    assert result["profile"]["sub_profiles"][0]["component_ids"] == ["robot/lamp"]
    assert list(result["component_profiles"]) == ["robot/lamp"]
    nothing = await app.ask("rois.system.get_profile", condition="component_ref = 'x'")
    assert nothing["component_profiles"] == {}
    assert (nothing["profile"]["component_ids"], nothing["profile"]["sub_profiles"]) == ([], [])


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
