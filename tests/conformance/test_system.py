"""The System interface: trees of engines behind an adapter, and requests right behind disconnect."""

from contextlib import AsyncExitStack

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.components import Lamp
from tests.support.deployment import Adapter, Application
from tests.support.plain import component_profile, engine_profile, plain_adapter, profile_result, refusal


async def test_every_level_lists_what_is_reachable_there(
    app: Application, gateway: Gateway, adapter: Adapter, stack: AsyncExitStack
) -> None:
    await stack.enter_async_context(deployment.two_level(adapter, Lamp(), engine_id="below"))
    await app.next("rois.system.profile_changed")
    profile = (await app.ask("rois.system.get_profile"))["profile"]
    assert (profile["identifier"]["code"], profile["identifier"]["authority"]) == ("gateway", "OpenRoIS")
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
