"""The Event interface: subscriptions, notifications, details."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.jsonrpc.outbox import EVENT_LIMIT
from tests.support import deployment
from tests.support import wire as memory
from tests.support.components import Bell
from tests.support.deployment import Adapter, Application, Robot


async def subscribe(app: Application, event_type: str = "rang", condition: str = "") -> str:
    answer = await app.ask("rois.event.subscribe", event_type=event_type, condition=condition)
    assert answer["return_code"] == "OK"
    return str(answer["subscribe_id"])


async def tunes(app: Application, count: int) -> list[str]:
    return [(await app.next("rois.event.notify_event"))["results"][0]["value"] for _ in range(count)]


async def test_which_component_is_meant(app: Application, subtests: pytest.Subtests) -> None:
    for event_type, condition, code in [
        ("rang", "", "OK"),
        ("rang", "component_ref = 'robot/bell'", "OK"),
        ("rang", "component_ref = 'robot/lamp'", "UNSUPPORTED"),
        ("shut", "", "UNSUPPORTED"),
        ("rang", "tune = 'ding'", "BAD_PARAMETER"),
        ("rang", "component_ref", "BAD_PARAMETER"),
    ]:
        with subtests.test(f"{event_type} {condition}"):
            answer = await app.ask("rois.event.subscribe", event_type=event_type, condition=condition)
            assert answer["return_code"] == code
            assert bool(answer["subscribe_id"]) == (code == "OK")


async def test_several_that_could_be_meant(app: Application, gateway: Gateway, stack: AsyncExitStack) -> None:
    await stack.enter_async_context(deployment.adapter(gateway, Bell(), engine_id="second"))
    await app.next("rois.system.profile_changed")
    answer = await app.ask("rois.event.subscribe", event_type="rang")
    assert answer == {"return_code": "BAD_PARAMETER", "subscribe_id": ""}


async def test_the_reply_comes_before_its_events_and_all_come_in_order(app: Application, robot: Robot) -> None:
    request_id = await app.begin("rois.event.subscribe", event_type="rang")
    robot.bell.ring("before or never")
    await app.answer(request_id)
    assert app.told == []
    for number in range(20):
        robot.bell.ring(str(number))
    heard = [tune for tune in await tunes(app, 20) if tune != "before or never"]
    assert heard == [str(number) for number in range(len(heard))]


async def test_a_notification(app: Application, robot: Robot) -> None:
    subscribe_id = await subscribe(app)
    robot.bell.ring("ding")
    notice = await app.next("rois.event.notify_event")
    assert (notice["event_type"], notice["subscribe_id"]) == ("rang", subscribe_id)
    assert notice["event_id"].startswith("robot/")
    assert notice["expire"].endswith("+00:00")
    assert notice["results"] == [{"name": "tune", "data_type_ref": "string", "value": "ding"}]


async def test_every_subscription_is_one_of_its_own(app: Application, robot: Robot) -> None:
    ids = {await subscribe(app), await subscribe(app), await subscribe(app)}
    assert len(ids) == 3
    robot.bell.ring("ding")
    notices = [await app.next("rois.event.notify_event") for _ in range(3)]
    assert {notice["subscribe_id"] for notice in notices} == ids
    assert len({notice["event_id"] for notice in notices}) == 1


async def test_nobody_hears_what_they_did_not_subscribe_to(app: Application, other: Application, robot: Robot) -> None:
    await subscribe(app)
    robot.bell.ring("ding")
    assert await tunes(app, 1) == ["ding"]
    assert await other.settled() == []


async def test_unsubscribe(app: Application, other: Application, robot: Robot) -> None:
    first, second = await subscribe(app), await subscribe(app)
    for subscribe_id in (first, first, "nobody's", ""):
        assert await app.ask("rois.event.unsubscribe", subscribe_id=subscribe_id) == {"return_code": "OK"}
    assert await other.ask("rois.event.unsubscribe", subscribe_id=second) == {"return_code": "OK"}
    robot.bell.ring("ding")
    assert (await app.next("rois.event.notify_event"))["subscribe_id"] == second
    assert await app.settled() == []


async def test_details(app: Application, other: Application, robot: Robot) -> None:
    await subscribe(app)
    robot.bell.ring("ding")
    notice = await app.next("rois.event.notify_event")
    asked = {"event_id": notice["event_id"]}
    assert await app.ask("rois.event.get_event_detail", **asked) == {"return_code": "OK", "results": notice["results"]}
    refused = {"return_code": "BAD_PARAMETER", "results": []}
    assert await other.ask("rois.event.get_event_detail", **asked) == refused
    for params in ({"event_id": "x"}, {"event_id": ""}, {**asked, "condition": "component_ref = 'x'"}):
        assert await app.ask("rois.event.get_event_detail", **params) == refused


async def test_events_of_commands(app: Application) -> None:
    await subscribe(app, "switched")
    assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"
    unit = {"component_ref": "robot/lamp", "command_type": "switch", "command_id": "c"}
    assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
    assert (await app.next("rois.event.notify_event"))["results"][0]["value"] == "1"
    await app.completed("c")


async def test_many_subscribers_are_one_at_the_adapter(
    app: Application, other: Application, robot: Robot, adapter: Adapter
) -> None:
    """Twenty subscriptions cost the adapter one notification for each event."""
    for session in (app, other):
        for _ in range(10):
            await subscribe(session)
    assert adapter.subscriptions == 1
    robot.bell.ring("ding")
    assert (await tunes(app, 10), await tunes(other, 10)) == (["ding"] * 10, ["ding"] * 10)


async def test_a_lost_adapter_takes_its_subscriptions_with_it(app: Application, adapter: Adapter, robot: Robot) -> None:
    subscribe_id = await subscribe(app)
    await adapter.stop()
    await adapter.start()
    robot.bell.ring("nobody hears it")
    assert await app.settled() == ["rois.system.profile_changed"] * 2
    assert await app.code("rois.event.unsubscribe", subscribe_id=subscribe_id) == "OK"
    await subscribe(app)
    robot.bell.ring("ding")
    assert await tunes(app, 1) == ["ding"]


async def test_a_session_that_ends_unsubscribes(adapter: Adapter, gateway: Gateway, app: Application) -> None:
    async with deployment.application(gateway) as leaving:
        await subscribe(leaving)
        assert adapter.subscriptions == 1
    while adapter.subscriptions:
        await app.settled()


async def test_a_late_subscription_is_ended_at_the_adapter(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    sessions = deployment.adapter_sessions(monkeypatch)
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, robot.bell) as adapter,
        deployment.application(gateway) as app,
    ):
        slow = deployment.Slow(adapter.host.engine.subscribe)
        monkeypatch.setattr(adapter.host.engine, "subscribe", slow)
        sessions[0].call_timeout = 0
        answer = await app.ask("rois.event.subscribe", event_type="rang")
        assert answer == {"return_code": "TIMEOUT", "subscribe_id": ""}
        slow.may_go_on.set()
        async with deployment.patience():
            await slow.done.wait()
            while adapter.subscriptions:
                await app.settled()
        robot.bell.ring("nobody hears it")
        assert await app.settled() == []


class TestEventsThatAreDropped:
    """An application reads too slowly: of the events that wait the oldest go."""

    @pytest.fixture
    async def bell(self) -> Bell:
        return Bell()

    @pytest.fixture
    async def slow(self, bell: Bell) -> AsyncIterator[memory.Application]:
        engine = Engine("gateway")
        await engine.attach(LocalRegistry("robot", [bell]))
        async with memory.hosted(engine) as host, memory.application(host) as app:
            yield app

    async def heard(self, app: memory.Application, count: int) -> list[Any]:
        """Return the next notifications: the tune of an event, or how many are missing."""
        async with deployment.patience():
            told = [await app.told.get() for _ in range(count)]
        return [params.get("count") or params["results"][0]["value"] for _, params in told]

    async def test_who_said_hello_is_told_how_many(self, slow: memory.Application, bell: Bell) -> None:
        await slow.ask("rois.event.subscribe", event_type="rang")
        await slow.ask("openrois.hello", version="1")
        for number in range(EVENT_LIMIT + 3):
            bell.ring(str(number))
        assert await self.heard(slow, 3) == [3, "3", "4"]

    async def test_who_speaks_the_base_is_not(self, slow: memory.Application, bell: Bell) -> None:
        await slow.ask("rois.event.subscribe", event_type="rang")
        for number in range(EVENT_LIMIT + 3):
            bell.ring(str(number))
        assert await self.heard(slow, 2) == ["3", "4"]
