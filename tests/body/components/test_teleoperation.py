import asyncio
import json

import pytest
from openrois_body.components.teleoperation import Teleoperation
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_streaming.input.messages import Held

from openrois.contract import Client, Event, SubscriptionLost
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, ComponentFailed, OutOfResources
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument
from openrois.types.streams import HolderNotification
from tests.support.streaming import VirtualClock, settle
from tests.support.teleoperation import Hand, LoggedControls, text

REF = "avatar/teleoperation"


class Bench:
    """The component with an application that holds it."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.controls = LoggedControls(self.clock)
        self.operator_control = OperatorControl(REF, self.clock)
        self.status = ComponentStatus.READY
        self.component = Teleoperation(self.operator_control, self.controls, lambda: self.status, self.clock)
        self.registry = LocalRegistry("avatar", [self.component])
        self.client = Client("ann", lambda _method, _params: None)
        self.told: list[dict[str, str]] = []
        """Messages that its application received on its own channel."""
        self.hands = self.operator_control.input_sink(self.client, lambda said: self.told.append(json.loads(said)))
        self.hand = Hand()
        self.heard: list[str] = []

    def hold(self, *, holds: bool = True) -> None:
        self.operator_control.apply_holder(HolderNotification(component_ref=REF, holds=holds, epoch=1), self.client)

    def press(self) -> None:
        self.hands.input_came("input", text(self.hand.state()))

    def hear(self, event: Event | SubscriptionLost) -> None:
        assert isinstance(event, Event)
        self.heard.append(event.results[0].value)

    async def operation(self) -> dict[str, str]:
        return {each.name: each.value for each in await self.registry.query(REF, "operation")}


@pytest.fixture
async def bench() -> Bench:
    made = Bench()
    await made.registry.subscribe(REF, "stopped", made.hear)
    return made


async def test_application_with_the_binding_starts_and_stops(bench: Bench) -> None:
    bench.hold()
    started = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    assert bench.component.status is ComponentStatus.BUSY
    bench.press()
    operation = await bench.operation()
    assert (operation["operated"], operation["active"], operation["ahead"]) == ("true", "true", "0.8")
    await bench.registry.invoke(REF, "stop")
    with pytest.raises(Aborted):
        await started
    assert bench.controls.words == ["drive", "halt"]
    assert bench.heard == ["teleoperation was stopped"]
    operation = await bench.operation()
    assert (operation["operated"], operation["ahead"], operation["taken"]) == ("false", "0.0", "1")


async def test_the_operation_is_told_as_it_is(bench: Bench) -> None:
    bench.press()
    bench.hold()
    started = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    assert {name: (await bench.operation())[name] for name in ("operated", "active", "taken", "refused")} == {
        "operated": "true",
        "active": "false",
        "taken": "0",
        "refused": "1",
    }
    bench.hands.input_came("control", "nonsense")
    bench.hands.input_came("input", text(bench.hand.state(Held(frozenset({"KeyS", "KeyE", "KeyA"})))))
    assert await bench.operation() == {
        "operated": "true",
        "active": "true",
        "ahead": "-0.8",
        "left": "-0.4",
        "turn": "1.5",
        "pace": "1.0",
        "stopped_because": "",
        "taken": "1",
        "refused": "1",
        "malformed": "1",
        "dropped": "0",
    }
    await bench.clock.advance(1)
    assert bench.told[-1] == {"event": "stopped", "reason": "no input came for 0.4 s"}
    again = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    with pytest.raises(Aborted):
        await started
    await settle()
    assert (await bench.operation())["stopped_because"] == ""
    again.cancel()
    await asyncio.wait({again})


async def test_start_without_a_binding_is_refused(bench: Bench) -> None:
    with pytest.raises(OutOfResources, match=REF):
        await bench.registry.invoke(REF, "start")


async def test_start_ends_when_the_component_is_released(bench: Bench) -> None:
    bench.hold()
    started = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    bench.press()
    bench.hold(holds=False)
    with pytest.raises(Aborted, match="released"):
        await started
    assert (bench.controls.words, bench.heard) == (["drive", "halt"], ["the component was released"])


async def test_without_input_it_stops_and_status_and_event_say_why(bench: Bench) -> None:
    bench.hold()
    started = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    bench.press()
    await bench.clock.advance(1)
    assert bench.heard == ["no input came for 0.4 s"]
    assert (await bench.operation())["stopped_because"] == "no input came for 0.4 s"
    assert not started.done()
    bench.press()
    assert bench.controls.words == ["drive", "halt", "drive"]
    await bench.registry.invoke(REF, "stop")
    with pytest.raises(Aborted):
        await started


async def test_a_second_start_takes_the_place_of_the_first(bench: Bench) -> None:
    bench.hold()
    first = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    second = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    with pytest.raises(Aborted):
        await first
    bench.press()
    assert bench.controls.words == ["drive"]
    await bench.registry.invoke(REF, "stop")
    with pytest.raises(Aborted):
        await second


async def test_its_parameters_hold_from_the_next_message_on(bench: Bench) -> None:
    bench.hold()
    started = asyncio.ensure_future(bench.registry.invoke(REF, "start"))
    await settle()
    speed = Argument(name="max_speed", data_type_ref="double", value="0.25")
    await bench.registry.invoke(REF, "set_parameter", (speed,))
    bench.press()
    assert (await bench.operation())["ahead"] == "0.25"
    await bench.registry.invoke(REF, "stop")
    with pytest.raises(Aborted):
        await started


async def test_status_follows_the_game_engine(bench: Bench) -> None:
    bench.status = ComponentStatus.ERROR
    assert bench.component.status is ComponentStatus.ERROR
    with pytest.raises(ComponentFailed):
        await bench.registry.invoke(REF, "start")
