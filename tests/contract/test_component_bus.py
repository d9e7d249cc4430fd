"""The contract of the five methods, over every way in which components can be reached."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import pytest

from openrois.adapter.dialer import serve_parent
from openrois.contract import ComponentBus, Event, Fault, FaultSource, SubscriptionLost
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed, RoISError, TimedOut, Unsupported
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.types.codes import ErrorType
from openrois.types.messages import Argument
from tests.support.components import Bell, Lamp
from tests.support.wire import adapter_leg, engine_over, hosted, proxied

LAMP, BELL = "robot/lamp", "robot/bell"


class Robot:
    """Two components and the registry that holds them."""

    def __init__(self) -> None:
        self.lamp, self.bell = Lamp(), Bell()
        self.registry = LocalRegistry("robot", [self.lamp, self.bell])


@asynccontextmanager
async def registry(robot: Robot) -> AsyncIterator[ComponentBus]:
    yield robot.registry


@asynccontextmanager
async def engine_over_registry(robot: Robot) -> AsyncIterator[ComponentBus]:
    async with engine_over(robot.registry) as engine:
        yield engine


@asynccontextmanager
async def engine_over_proxy_over_engine(robot: Robot) -> AsyncIterator[ComponentBus]:
    async with (
        engine_over(robot.registry, engine_id="robot") as adapter,
        proxied(adapter) as proxy,
        engine_over(proxy) as gateway,
    ):
        yield gateway


@asynccontextmanager
async def two_wire_hops(robot: Robot) -> AsyncIterator[ComponentBus]:
    async with (
        engine_over(robot.registry, engine_id="robot") as adapter,
        engine_over(engine_id="fleet") as middle,
        hosted(middle) as middle_host,
        adapter_leg(middle_host, adapter),
        proxied(middle) as proxy,
        engine_over(proxy) as gateway,
    ):
        yield gateway


@asynccontextmanager
async def websocket_hop(robot: Robot) -> AsyncIterator[ComponentBus]:
    adapter = Engine("robot")
    await adapter.attach(robot.registry)
    async with run_gateway(GatewaySettings(port=0)) as gateway, hosted(adapter) as host:
        attached = asyncio.Event()
        gateway.engine.on_change(attached.set)
        dialling = asyncio.ensure_future(serve_parent(host, gateway.url.replace("http", "ws") + "adapter"))
        try:
            async with asyncio.timeout(60):
                await attached.wait()
            yield gateway.engine
        finally:
            dialling.cancel()
            await asyncio.wait({dialling}, timeout=5)


TOPOLOGIES: list[Callable[[Robot], AbstractAsyncContextManager[ComponentBus]]] = [
    registry,
    engine_over_registry,
    engine_over_proxy_over_engine,
    two_wire_hops,
    websocket_hop,
]


@pytest.fixture
async def robot() -> Robot:
    return Robot()


@pytest.fixture(params=TOPOLOGIES, ids=lambda topology: topology.__name__)
async def bus(request: pytest.FixtureRequest, robot: Robot) -> AsyncIterator[ComponentBus]:
    async with request.param(robot) as bus:
        yield bus


class Heard:
    """A sink that keeps what it was given and can be waited for."""

    def __init__(self) -> None:
        self.items: asyncio.Queue[Event | SubscriptionLost] = asyncio.Queue()

    def __call__(self, item: Event | SubscriptionLost) -> None:
        self.items.put_nowait(item)

    async def next(self) -> Event | SubscriptionLost:
        async with asyncio.timeout(60):
            return await self.items.get()


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="string", value=value)


async def test_discover_reports_references_and_profiles_unchanged(bus: ComponentBus, robot: Robot) -> None:
    directory = await bus.discover()
    assert set(directory.profile.component_refs()) == {LAMP, BELL}
    assert directory.component_profiles[LAMP] == robot.lamp.profile


async def test_query_returns_results(bus: ComponentBus) -> None:
    (status,) = await bus.query(LAMP, "component_status")
    assert (status.name, status.value) == ("status", "READY")


async def test_query_of_parameters(bus: ComponentBus) -> None:
    stored = await bus.query(LAMP, "get_parameter")
    assert {p.name: p.value for p in stored} == {"colour": "white", "level": "5"}


@pytest.mark.parametrize(("ref", "query"), [("robot/absent", "component_status"), ("nowhere/lamp", "x"), (LAMP, "x")])
async def test_query_of_the_unknown_is_unsupported(bus: ComponentBus, ref: str, query: str) -> None:
    with pytest.raises(Unsupported):
        await bus.query(ref, query)


async def test_invoke_runs_to_the_end_and_returns_results(bus: ComponentBus, robot: Robot) -> None:
    (total,) = await bus.invoke(LAMP, "switch", (argument("times", "3"),))
    assert (total.value, robot.lamp.total) == ("3", 3)


async def test_invoke_set_parameter_changes_all_or_nothing(bus: ComponentBus, robot: Robot) -> None:
    await bus.invoke(LAMP, "set_parameter", (argument("colour", "red"), argument("level", "7")))
    with pytest.raises(BadParameter):
        await bus.invoke(LAMP, "set_parameter", (argument("colour", "blue"), argument("level", "much")))
    assert robot.lamp.parameters == {"colour": "red", "level": 7}


@pytest.mark.parametrize(
    ("command", "error"), [("fail", ComponentFailed), ("time_out", TimedOut), ("crash", ComponentFailed)]
)
async def test_invoke_fails_as_the_component_does(bus: ComponentBus, command: str, error: type[RoISError]) -> None:
    with pytest.raises(error):
        await bus.invoke(LAMP, command)


async def test_invoke_of_the_unknown_is_unsupported(bus: ComponentBus) -> None:
    for ref, name in (("robot/absent", "start"), ("nowhere/lamp", "start"), (LAMP, "explode")):
        with pytest.raises(Unsupported):
            await bus.invoke(ref, name)


async def test_stop_aborts_a_running_start(bus: ComponentBus, robot: Robot) -> None:
    running = asyncio.ensure_future(bus.invoke(LAMP, "start"))
    async with asyncio.timeout(60):
        await robot.lamp.glowing.wait()
    (status,) = await bus.query(LAMP, "component_status")
    assert status.value == "BUSY"
    await bus.invoke(LAMP, "stop")
    with pytest.raises(Aborted):
        await running


async def test_a_new_start_aborts_the_former(bus: ComponentBus, robot: Robot) -> None:
    first = asyncio.ensure_future(bus.invoke(LAMP, "start"))
    async with asyncio.timeout(60):
        await robot.lamp.glowing.wait()
    second = asyncio.ensure_future(bus.invoke(LAMP, "start"))
    with pytest.raises(Aborted):
        await first
    robot.lamp.may_end.set()
    assert await second == ()


async def test_subscribers_hear_events_in_order_until_they_unsubscribe(bus: ComponentBus, robot: Robot) -> None:
    first, second = Heard(), Heard()
    first_id = await bus.subscribe(BELL, "rang", first)
    await bus.subscribe(BELL, "rang", second)
    for tune in ("ding", "dong"):
        robot.bell.ring(tune)
    for heard in (first, second):
        events = [await heard.next(), await heard.next()]
        assert [event.results[0].value for event in events if isinstance(event, Event)] == ["ding", "dong"]
        assert all(isinstance(event, Event) and event.component_ref == BELL for event in events)
    await bus.unsubscribe(first_id)
    robot.bell.ring("late")
    assert isinstance(await second.next(), Event)
    assert first.items.empty()


async def test_an_event_right_after_the_component_took_the_subscription_is_heard(
    bus: ComponentBus, robot: Robot
) -> None:
    heard = Heard()
    asyncio.get_running_loop().call_soon(robot.bell.ring, "too early, or not")
    await bus.subscribe(BELL, "rang", heard)
    robot.bell.ring("now")
    while True:
        event = await heard.next()
        assert isinstance(event, Event)
        if event.results[0].value == "now":
            return


async def test_subscribe_to_the_unknown_is_unsupported(bus: ComponentBus) -> None:
    for ref, name in (("robot/absent", "rang"), ("nowhere/bell", "rang"), (BELL, "exploded")):
        with pytest.raises(Unsupported):
            await bus.subscribe(ref, name, Heard())


async def test_unsubscribe_of_the_unknown_is_ignored(bus: ComponentBus) -> None:
    await bus.unsubscribe("nothing")


async def test_a_fault_of_a_component_is_told_with_what_is_known_of_it(bus: ComponentBus, robot: Robot) -> None:
    told: asyncio.Queue[Fault] = asyncio.Queue()
    assert isinstance(bus, FaultSource)
    bus.on_fault = told.put_nowait
    with pytest.raises(ComponentFailed):
        await bus.invoke(LAMP, "crash")
    robot.bell.report(ErrorType.USER_DEFINED_ERROR, "cracked")
    async with asyncio.timeout(60):
        faults = [await told.get(), await told.get()]
    assert [(fault.error_type, fault.component_ref, fault.description) for fault in faults] == [
        (ErrorType.COMPONENT_INTERNAL_ERROR, LAMP, "lamp: crash failed: a bug"),
        (ErrorType.USER_DEFINED_ERROR, BELL, "cracked"),
    ]
    assert all(fault.error_id.startswith("robot/") and fault.timestamp.endswith("+00:00") for fault in faults)
    assert len({fault.error_id for fault in faults}) == 2


async def test_many_calls_at_once(bus: ComponentBus, robot: Robot) -> None:
    outcomes = await asyncio.gather(*(bus.invoke(LAMP, "switch") for _ in range(50)))
    assert sorted(int(results[0].value) for results in outcomes) == list(range(1, 51))
    assert robot.lamp.total == 50
