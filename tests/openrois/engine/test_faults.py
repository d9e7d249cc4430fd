"""Faults from a component up to the listeners of an engine above it."""

import asyncio

import pytest

from openrois.component.authoring.marks import command, query
from openrois.component.component import Component
from openrois.contract import Fault, FaultSource
from openrois.engine.engine import Engine
from openrois.engine.faults import FAULTS_AT_ONCE, FaultMint
from openrois.engine.registry import LocalRegistry
from openrois.errors import ComponentFailed, NotResponding, TimedOut
from openrois.types.codes import ErrorType
from openrois.types.messages import Result
from openrois.types.references import engine_of
from tests.support.clock import Clock


class Clumsy(Component):
    """Raises in its query, and never ends its command."""

    @query
    async def mood(self) -> str:
        raise KeyError("moods")

    @query
    async def refuse(self) -> str:
        raise ComponentFailed("not today")

    @command(timeout=0.001)
    async def dawdle(self) -> None:
        await asyncio.Event().wait()


class Patient(Component):
    """Does nothing."""


class Heard:
    """The faults that an engine notified."""

    def __init__(self, engine: Engine) -> None:
        self.faults: list[Fault] = []
        self.times = 0
        self.leave = engine.faults.add(self._note)

    def _note(self, faults: tuple[Fault, ...]) -> None:
        self.times += 1
        self.faults += faults

    def __call__(self) -> list[tuple[ErrorType, str]]:
        return [(fault.error_type, fault.component_ref) for fault in self.faults]


@pytest.fixture
async def clumsy() -> Clumsy:
    return Clumsy()


@pytest.fixture
async def registry(clumsy: Clumsy) -> LocalRegistry:
    return LocalRegistry("robot", [clumsy], wall_clock=Clock(0.0))


@pytest.fixture
async def robot(registry: LocalRegistry) -> Engine:
    engine = Engine("robot")
    await engine.attach(registry)
    return engine


class TestComponents:
    async def test_one_that_raises_is_an_internal_error(self, robot: Engine) -> None:
        heard = Heard(robot)
        with pytest.raises(ComponentFailed):
            await robot.query("robot/clumsy", "mood")
        (fault,) = heard.faults
        assert fault.error_type is ErrorType.COMPONENT_INTERNAL_ERROR
        assert fault.component_ref == "robot/clumsy"
        assert fault.description == "clumsy: mood failed: 'moods'"
        assert fault.timestamp == "1970-01-01T00:00:00.000000+00:00"
        assert engine_of(fault.error_id) == "robot"

    async def test_one_that_refuses_has_no_fault(self, robot: Engine) -> None:
        heard = Heard(robot)
        with pytest.raises(ComponentFailed):
            await robot.query("robot/clumsy", "refuse")
        assert heard() == []

    async def test_one_that_takes_too_long_does_not_respond(self, robot: Engine) -> None:
        heard = Heard(robot)
        with pytest.raises(TimedOut):
            await robot.invoke("robot/clumsy", "dawdle")
        assert heard() == [(ErrorType.COMPONENT_NOT_RESPONDING, "robot/clumsy")]

    async def test_one_may_report_what_it_likes(self, robot: Engine, clumsy: Clumsy) -> None:
        heard = Heard(robot)
        clumsy.report(ErrorType.USER_DEFINED_ERROR, "the paint is off")
        (fault,) = heard.faults
        assert (fault.error_type, fault.description) == (ErrorType.USER_DEFINED_ERROR, "the paint is off")

    async def test_a_component_without_registry_reports_nowhere(self) -> None:
        with pytest.raises(ComponentFailed):
            await Clumsy().ask("mood")


class Silent:
    """A bus that never answers, and cannot tell of faults."""

    def __init__(self, registry: LocalRegistry) -> None:
        self.discover = registry.discover

    async def query(self, *_arguments: object) -> tuple[Result, ...]:
        raise NotResponding("no answer")

    invoke = query

    async def subscribe(self, *_arguments: object) -> str:
        raise NotResponding("no answer")

    async def unsubscribe(self, _subscribe_id: str) -> None:
        """Nothing is subscribed."""


class TestEngines:
    async def test_a_call_without_an_answer_is_the_fault_of_the_component(self, registry: LocalRegistry) -> None:
        gateway = Engine("gateway")
        await gateway.attach(Silent(registry))
        heard = Heard(gateway)
        for call in (
            gateway.query("robot/clumsy", "mood"),
            gateway.invoke("robot/clumsy", "dawdle"),
            gateway.subscribe("robot/clumsy", "x", lambda _item: None),
        ):
            with pytest.raises(TimedOut) as raised:
                await call
            assert not isinstance(raised.value, NotResponding), "the next engine up would report it again"
        assert heard() == [(ErrorType.COMPONENT_NOT_RESPONDING, "robot/clumsy")] * 3
        assert {engine_of(fault.error_id) for fault in heard.faults} == {"gateway"}

    async def test_what_an_engine_reports_of_itself_has_no_component(self, robot: Engine) -> None:
        heard = Heard(robot)
        robot.report(ErrorType.ENGINE_INTERNAL_ERROR, "oops")
        assert heard() == [(ErrorType.ENGINE_INTERNAL_ERROR, "")]

    async def test_faults_rise_through_engines_until_they_are_detached(self, robot: Engine, clumsy: Clumsy) -> None:
        fleet = Engine("fleet")
        await fleet.attach(robot)
        here, above = Heard(robot), Heard(fleet)
        clumsy.report(ErrorType.USER_DEFINED_ERROR, "one")
        robot.report(ErrorType.ENGINE_INTERNAL_ERROR, "two")
        assert here.faults == above.faults
        assert len(above.faults) == 2
        fleet.detach(robot)
        clumsy.report(ErrorType.USER_DEFINED_ERROR, "three")
        assert (len(here.faults), len(above.faults)) == (3, 2)

    async def test_those_of_a_lost_connection_come_together(self) -> None:
        registry = LocalRegistry("robot", [Clumsy(), Patient()])
        gateway = Engine("gateway")
        await gateway.attach(registry)
        heard = Heard(gateway)
        gateway.detach(registry, lost="the connection ended")
        assert heard() == [(ErrorType.COMPONENT_NOT_RESPONDING, f"robot/{name}") for name in ("clumsy", "patient")]
        assert heard.times == 1

    async def test_which_bus_can_tell_of_faults(self, robot: Engine, registry: LocalRegistry) -> None:
        assert isinstance(robot, FaultSource)
        assert isinstance(registry, FaultSource)
        assert not isinstance(Silent(registry), FaultSource)


class TestMint:
    def test_a_flood_is_cut(self, caplog: pytest.LogCaptureFixture) -> None:
        clock = Clock()
        mint = FaultMint("robot", clock, clock)
        made = [mint.make(ErrorType.USER_DEFINED_ERROR, "", "x") for _ in range(FAULTS_AT_ONCE + 10)]
        assert made.count(None) == 10
        assert "were not reported, too many at a time: 8 so far" in caplog.text
        clock.now += 1
        assert mint.make(ErrorType.USER_DEFINED_ERROR, "", "x") is not None

    def test_a_long_description_is_cut(self) -> None:
        fault = FaultMint("robot").make(ErrorType.USER_DEFINED_ERROR, "", "x" * 5000)
        assert fault is not None
        assert len(fault.description) == 1000
