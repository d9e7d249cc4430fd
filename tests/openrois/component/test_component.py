"""Status, life and hooks of a component in this process. What it shares with remote ones is in `tests/contract`."""

import asyncio
from typing import Any, cast

import pytest

from openrois.component.authoring.marks import command, query
from openrois.component.authoring.parameters import parameter
from openrois.component.component import Component
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed
from openrois.types.codes import ComponentStatus, ErrorType
from tests.support.components import Bell, Lamp
from tests.support.thing import Device, Thing, argument, began


class TestStatus:
    async def test_busy_while_a_command_runs(self, thing: Thing) -> None:
        assert thing.status.value == "READY"
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        assert thing.status.value == "BUSY"
        (status,) = await thing.ask("component_status")
        assert (status.name, status.data_type_ref, status.value) == ("status", "Component_Status", "BUSY")
        assert (await thing.ask("shape"))[0].value == "round"
        thing.may_end.set()
        await running
        assert thing.status.value == "READY"

    @pytest.mark.parametrize("status", ["UNINITIALIZED", "WARNING", "ERROR"])
    async def test_a_component_that_cannot_work_says_so_and_nothing_else(self, thing: Thing, status: str) -> None:
        thing.is_in = ComponentStatus(status)
        assert (await thing.ask("component_status"))[0].value == status
        assert await thing.ask("get_parameter") == ()
        assert await thing.run("set_parameter", ()) == ()
        with pytest.raises(ComponentFailed, match=status):
            await thing.ask("shape")
        with pytest.raises(ComponentFailed, match=status):
            await thing.run("start", ())
        assert thing.starts == []

    async def test_nor_can_it_be_listened_to(self) -> None:
        class Mute(Bell):
            def condition(self) -> ComponentStatus:
                return ComponentStatus.ERROR

        with pytest.raises(ComponentFailed, match="ERROR"):
            await LocalRegistry("robot", [Mute()]).subscribe("robot/bell", "rang", lambda _item: None)

    async def test_trouble_shows_while_a_command_runs(self, thing: Thing) -> None:
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        thing.is_in = ComponentStatus.ERROR
        assert thing.status.value == "ERROR"
        thing.may_end.set()
        await running

    @pytest.mark.parametrize("trouble", [ComponentStatus.ERROR, ComponentStatus.WARNING])
    async def test_what_does_not_work_is_told_to_stop_all_the_same(
        self, thing: Thing, trouble: ComponentStatus
    ) -> None:
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        thing.is_in = trouble
        with pytest.raises(ComponentFailed, match=trouble.value):
            await thing.run("stop", ())
        assert thing.stopped == 1
        with pytest.raises(Aborted):
            await running
        assert thing.starts == ["begins", "ends"]


class TestStart:
    async def test_stop_ends_it_with_abort_after_the_stop_ran(self, thing: Thing) -> None:
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        assert await thing.run("stop", ()) == ()
        assert thing.stopped == 1
        with pytest.raises(Aborted):
            await running
        assert thing.starts == ["begins", "ends"]
        assert thing.status.value == "READY"

    async def test_stop_with_nothing_to_stop(self, thing: Thing) -> None:
        assert await thing.run("stop", ()) == ()

    async def test_of_many_starts_one_runs_at_a_time(self, thing: Thing) -> None:
        starts = [asyncio.ensure_future(thing.run("start", ())) for _ in range(4)]
        await began(thing)
        for _ in range(30):
            await asyncio.sleep(0)
        assert thing.starts.count("begins") - thing.starts.count("ends") == 1
        thing.may_end.set()
        outcomes = await asyncio.gather(*starts, return_exceptions=True)
        assert [type(outcome) for outcome in outcomes].count(Aborted) == 3
        assert outcomes.count(()) == 1

    async def test_cancelling_the_caller_ends_it(self, thing: Thing) -> None:
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running
        assert thing.starts == ["begins", "ends"]
        assert thing.status.value == "READY"

    async def test_a_start_that_fails_when_its_caller_is_cancelled_is_not_forgotten(self) -> None:
        class Stubborn(Thing):
            async def start(self) -> None:
                self.begun.set()
                try:
                    await asyncio.Event().wait()
                except asyncio.CancelledError:
                    raise ComponentFailed("no") from None

        stubborn = Stubborn()
        running = asyncio.ensure_future(stubborn.run("start", ()))
        await began(stubborn)
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running

    async def test_other_commands_run_beside_it(self, thing: Thing) -> None:
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        assert await thing.run("pause", ()) == ()
        assert not running.done()
        thing.may_end.set()
        await running


class TestLife:
    async def test_uninitialized_until_it_is_connected(self) -> None:
        device = Device(None)
        assert device.name == "device"
        assert device.status.value == "UNINITIALIZED"
        with pytest.raises(ComponentFailed, match="UNINITIALIZED"):
            await device.run("start", ())
        await device.run("set_parameter", (argument("tempo", "90"),))
        assert (await device.ask("get_parameter"))[0].value == "90"
        assert await device.bring_up()
        assert device.status.value == "READY"

    @pytest.mark.parametrize(
        ("error", "reported"), [(ComponentFailed("no power"), 0), (OSError("no such device"), 1), (TimeoutError(), 1)]
    )
    async def test_a_connect_that_fails(
        self, error: Exception, reported: int, caplog: pytest.LogCaptureFixture
    ) -> None:
        device = Device(error, None)
        faults: list[ErrorType] = []
        device.report = lambda kind, _description: faults.append(kind)
        assert not await device.bring_up()
        assert device.status.value == "ERROR"
        assert faults == [ErrorType.COMPONENT_INTERNAL_ERROR] * reported
        assert str(error) in caplog.text
        with pytest.raises(ComponentFailed, match=rf"does not work now \(ERROR\): .*{error}$"):
            await device.run("start", ())
        assert await device.bring_up()
        assert device.status.value == "READY"

    async def test_a_refusal_says_what_is_the_problem(self, thing: Thing) -> None:
        thing.is_in = ComponentStatus.WARNING
        with pytest.raises(ComponentFailed, match=r"does not work now \(WARNING\)$"):
            await thing.run("start", ())
        thing.problem = lambda: "its motors are off"  # type: ignore[method-assign]
        with pytest.raises(ComponentFailed, match=r"does not work now \(WARNING\): its motors are off$"):
            thing.require_usable("robot/thing")

    async def test_what_was_connected_is_let_go(self) -> None:
        device = Device(None)
        await device.bring_up()
        running = asyncio.ensure_future(device.run("start", ()))
        async with asyncio.timeout(60):
            await device.started.wait()
        await device.take_down()
        with pytest.raises(Aborted):
            await running
        assert device.calls == ["connect", "start", "disconnect"]
        assert device.status.value == "UNINITIALIZED"

    async def test_what_never_was_connected_is_not_let_go(self) -> None:
        device = Device(OSError("no"))
        await device.take_down()
        await device.bring_up()
        await device.take_down()
        assert device.calls == ["connect"]

    @pytest.mark.parametrize("stuck", [True, False])
    async def test_a_disconnect_that_fails_or_takes_too_long_is_over_in_time(
        self, stuck: bool, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        class Clinging(Device):
            async def disconnect(self) -> None:
                if stuck:
                    await asyncio.Event().wait()
                raise OSError("it clings")

        monkeypatch.setattr("openrois.component.component.DISCONNECT_TIMEOUT", 0.001)
        clinging = Clinging(None)
        await clinging.bring_up()
        async with asyncio.timeout(60):
            await clinging.take_down()
        assert ("it took too long" if stuck else "it clings") in caplog.text


async def test_an_own_init_need_not_call_the_component() -> None:
    class Careless(Lamp):
        def __init__(self) -> None:
            self.level = 3

    careless = Careless()
    assert (careless.name, careless.level) == ("lamp", 3)
    assert (await careless.ask("brightness"))[0].value == "3"
    assert careless.profile.name == "lamp"


async def test_an_author_may_use_any_private_name() -> None:
    class Own(Lamp):
        def __init__(self) -> None:
            super().__init__()
            self._running = self._start = self._loop = self._standing = self._kind = self._omitted = "mine"

        def _call(self) -> str:
            return "mine"

        _read = _run_start = _abort_start = _set_parameters = _run_checked = _call

    own = Own()
    await own.bring_up()
    assert own.status.value == "READY"
    assert (await own.run("switch", (argument("times", "2"),)))[0].value == "2"
    await own.run("set_parameter", (argument("level", "1"),))
    running = asyncio.ensure_future(own.run("start", ()))
    async with asyncio.timeout(60):
        await own.glowing.wait()
    await own.take_down()
    with pytest.raises(Aborted):
        await running


def test_there_is_no_component_as_such() -> None:
    with pytest.raises(TypeError, match="is a base class"):
        Component()


@pytest.mark.parametrize("name", ["", "a/b", "x" * 129])
async def test_a_name_that_cannot_be_part_of_a_reference(name: str) -> None:
    with pytest.raises(BadParameter, match="name"):
        Bell(name)


class TestHooks:
    """What an author gets wrong is the component's ERROR: it is answered, logged and reported."""

    class Clumsy(Component):
        level: int = parameter(1)

        def __init__(self) -> None:
            super().__init__("clumsy")
            self.faults: list[str] = []
            self.report = lambda _kind, description: self.faults.append(description)
            self.work: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self.is_in: Any = ComponentStatus.READY

        def condition(self) -> ComponentStatus:
            if isinstance(self.is_in, Exception):
                raise self.is_in
            return cast(ComponentStatus, self.is_in)

        def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
            return cast(dict[str, Any], {1: changes, 2: None, 3: {"colour": "red"}}[changes["level"]])

        @command
        async def start(self) -> None:
            await self.work

        @command
        async def wait(self) -> None:
            await self.work

        @query
        async def waited(self) -> bool:
            await self.work
            return True

    @pytest.mark.parametrize("is_in", [KeyError("port"), "broken"])
    async def test_a_condition_that_is_none(self, is_in: Any, caplog: pytest.LogCaptureFixture) -> None:
        clumsy = self.Clumsy()
        clumsy.is_in = is_in
        assert (await clumsy.ask("component_status"))[0].value == "ERROR"
        with pytest.raises(ComponentFailed, match="does not work now"):
            await clumsy.run("wait", ())
        assert clumsy.faults[0].startswith("clumsy: condition failed: ")
        assert "in condition" in caplog.text or "is not a valid ComponentStatus" in caplog.text

    async def test_a_condition_that_says_why(self) -> None:
        clumsy = self.Clumsy()
        clumsy.is_in = ComponentFailed("unplugged")
        assert clumsy.status is ComponentStatus.ERROR
        assert clumsy.faults == []

    @pytest.mark.parametrize(
        ("level", "why"), [("2", "accept_parameters returned None: return what to store"), ("3", "colour"), ("4", "4")]
    )
    async def test_parameters_that_are_accepted_wrongly(self, level: str, why: str) -> None:
        clumsy = self.Clumsy()
        with pytest.raises(ComponentFailed, match=f"clumsy: set_parameter failed: .*{why}"):
            await clumsy.run("set_parameter", (argument("level", level),))
        assert len(clumsy.faults) == 1
        assert clumsy.level == 1

    async def test_what_a_message_waits_for_may_be_cancelled(self) -> None:
        """An own task of the component's that is cancelled does not cancel the caller, which gets an answer."""
        clumsy = self.Clumsy()
        clumsy.work.cancel()
        for name in ("wait", "start"):
            with pytest.raises(Aborted):
                await clumsy.run(name, ())
        with pytest.raises(Aborted, match="waited failed: a task that it awaited was cancelled"):
            await clumsy.ask("waited")
        assert clumsy.status is ComponentStatus.READY

    async def test_a_connect_whose_work_is_cancelled_is_tried_again(self) -> None:
        class Device(Component):
            async def connect(self) -> None:
                work: asyncio.Future[None] = asyncio.get_running_loop().create_future()
                work.cancel()
                await work

        device = Device()
        assert not await device.bring_up()
        assert device.status is ComponentStatus.ERROR
