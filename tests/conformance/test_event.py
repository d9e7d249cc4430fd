"""The Event interface: shared subscriptions, lost adapters, and events that are dropped."""

from collections.abc import AsyncIterator
from typing import Any

import pytest

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
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
    robot.bell.ring("unheard")
    assert await app.settled() == ["rois.system.profile_changed"] * 2
    assert await app.code("rois.event.unsubscribe", subscribe_id=subscribe_id) == "OK"
    await subscribe(app)
    robot.bell.ring("ding")
    assert await tunes(app, 1) == ["ding"]


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

    async def test_after_hello_the_number_of_dropped_events_is_notified(
        self, slow: memory.Application, bell: Bell
    ) -> None:
        await slow.ask("rois.event.subscribe", event_type="rang")
        await slow.ask("openrois.hello", version="1")
        for number in range(EVENT_LIMIT + 3):
            bell.ring(str(number))
        assert await self.heard(slow, 3) == [3, "3", "4"]

    async def test_without_hello_it_is_not(self, slow: memory.Application, bell: Bell) -> None:
        await slow.ask("rois.event.subscribe", event_type="rang")
        for number in range(EVENT_LIMIT + 3):
            bell.ring(str(number))
        assert await self.heard(slow, 2) == ["3", "4"]
