"""An adapter is notified which application holds its actuation components, and no other adapter is notified."""

from collections.abc import AsyncIterator
from dataclasses import dataclass, field

import pytest

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Unsupported
from openrois.gateway.server import Gateway
from openrois.session.session import EngineHost
from tests.support.components import Lamp
from tests.support.deployment import Adapter, Application, Robot, adapter, application, gateway, patience, until
from tests.support.streams import FakeStreams

HOLDER = "openrois.holder"
LAMP = "robot/lamp"


@dataclass
class House:
    """A gateway with an adapter whose engine has another one below it."""

    gateway: Gateway
    adapter: Adapter
    robot: Robot
    below: FakeStreams = field(default_factory=lambda: FakeStreams("arm"))

    async def holds(self, count: int, streams: FakeStreams | None = None) -> list[tuple[str, bool, int, str]]:
        """Wait until so many notifications came, and return them: component, holds, epoch and client."""
        told = streams or self.robot.streams
        async with patience():
            while len(found := [call for call in told.calls if call[0] == HOLDER]) < count:
                told.called.clear()
                await told.called.wait()
        # A gateway counts on from the time that it was started at.
        before = found[0][1]["epoch"] - 1
        return [
            (params["component_ref"], params["holds"], params["epoch"] - before, client) for _, params, client in found
        ]


@pytest.fixture
async def house() -> AsyncIterator[House]:
    async with gateway() as running:
        robot = Robot()
        async with adapter(running, *robot.parts(), extension=robot.streams) as attached:
            made = House(running, attached, robot)
            arm = Engine("arm")
            await arm.attach(LocalRegistry("arm", [Lamp()], extension=made.below))
            await attached.host.engine.attach(arm)
            yield made


async def bound(app: Application, component_ref: str = LAMP) -> str:
    hello = await app.ask("openrois.hello", version="1", extensions=[])
    await app.eventually("OK", "rois.command.bind", component_ref=component_ref)
    return str(hello["client_id"])


async def test_bind_and_release_are_notified(house: House) -> None:
    async with application(house.gateway) as ann, application(house.gateway) as bob:
        ann_id, bob_id = await bound(ann), (await bob.ask("openrois.hello", version="1", extensions=[]))["client_id"]
        assert await bob.code("rois.command.bind", component_ref=LAMP) == "OUT_OF_RESOURCES"
        assert await bob.code("rois.command.release", component_ref=LAMP) == "OK"
        assert await ann.code("rois.command.bind", component_ref=LAMP) == "OK"
        assert await ann.code("rois.command.release", component_ref=LAMP) == "OK"
        assert await bob.code("rois.command.bind", component_ref=LAMP) == "OK"
        told = await house.holds(4)
    assert told == [(LAMP, True, 1, ann_id), (LAMP, True, 1, ann_id), (LAMP, False, 1, ann_id), (LAMP, True, 2, bob_id)]


async def test_a_departed_application_is_dropped_there_too(house: House) -> None:
    async with application(house.gateway) as ann:
        ann_id = await bound(ann)
        await house.holds(1)
    async with patience():
        await house.robot.streams.gone.wait()
    assert house.robot.streams.forgotten == [ann_id]


async def test_when_the_connection_to_the_gateway_ends_every_lease_ends(house: House) -> None:
    async with application(house.gateway) as ann:
        ann_id = await bound(ann)
        await house.holds(1)
        await house.adapter.stop()
        assert await house.holds(2) == [(LAMP, True, 1, ann_id), (LAMP, False, 1, ann_id)]
        await house.adapter.start()
        await ann.eventually("OK", "rois.command.bind", component_ref=LAMP)
        assert (await house.holds(3))[2] == (LAMP, True, 2, ann_id)


async def test_the_engine_below_is_told_what_is_its_own(house: House) -> None:
    async with application(house.gateway) as ann:
        ann_id = await bound(ann, "arm/lamp")
        assert await house.holds(1, house.below) == [("arm/lamp", True, 1, ann_id)]
    async with patience():
        await house.below.gone.wait()
    assert [call for call in house.robot.streams.calls if call[0] == HOLDER] == []


async def test_what_needs_no_reservation_has_no_holder(house: House) -> None:
    async with application(house.gateway) as ann:
        await bound(ann, "robot/bell")
        await bound(ann)
        assert [component_ref for component_ref, *_ in await house.holds(1)] == [LAMP]


async def test_an_engine_that_does_not_want_to_know(house: House) -> None:
    house.robot.streams.refusal = Unsupported("what is a holder?")
    async with application(house.gateway) as ann:
        await bound(ann)
        await house.holds(1)
        house.robot.streams.refusal = None
        assert await ann.code("rois.command.bind", component_ref=LAMP) == "OK"
        await house.holds(2)


async def test_an_adapter_without_streams_is_told_nothing() -> None:
    async with gateway() as running, adapter(running, Lamp()), application(running) as ann:
        await bound(ann)
        assert await ann.code("rois.command.release", component_ref=LAMP) == "OK"


async def test_over_two_connections(house: House) -> None:
    """A gateway behind a gateway: the one in front learns of each bind, and the adapter behind both is notified."""
    async with gateway(engine_id="front") as front, TaskScope() as tasks:
        behind = EngineHost(house.gateway.engine, tasks)
        dialling = tasks.start(serve_parent(behind, front.url.replace("http", "ws") + "adapter"))
        await until(front.engine, lambda ids: "robot" in ids)
        async with application(front) as ann:
            ann_id = await bound(ann)
            assert await house.holds(1) == [(LAMP, True, 1, ann_id)]
            assert await ann.code("rois.command.release", component_ref=LAMP) == "OK"
            assert (await house.holds(2))[1] == (LAMP, False, 1, ann_id)
            assert await ann.code("rois.command.bind", component_ref=LAMP) == "OK"
            await house.holds(3)
            dialling.cancel()
            assert (await house.holds(4))[3] == (LAMP, False, 2, ann_id)
