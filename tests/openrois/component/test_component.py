"""What every component in this process does by itself. What it shares with remote ones is in `tests/contract`."""

import asyncio
import logging
import threading
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any, cast

import pytest
from pydantic import Field

from openrois.adapter.components import GestureRecognition, PersonDetection
from openrois.catalog.payload import Data, Payload
from openrois.component.authoring.marks import command, event, query
from openrois.component.authoring.parameters import parameter
from openrois.component.component import Component
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed, TimedOut, Unsupported
from openrois.types.codes import ComponentStatus, ErrorType
from openrois.types.messages import Argument, Result
from tests.support.components import Bell, Lamp


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="ignored", value=value)


class Thing(Component):
    """Its condition and what `start` and `dawdle` do are set by the test."""

    def __init__(self) -> None:
        super().__init__("thing")
        self.is_in = ComponentStatus.READY
        self.starts: list[str] = []
        self.begun = asyncio.Event()
        self.may_end = asyncio.Event()
        self.stopped = 0

    def condition(self) -> ComponentStatus:
        return self.is_in

    @query
    async def shape(self) -> str:
        return "round"

    @command
    async def start(self) -> None:
        self.starts.append("begins")
        self.begun.set()
        try:
            await self.may_end.wait()
        finally:
            self.starts.append("ends")

    @command
    async def stop(self) -> None:
        self.stopped += 1

    @command
    async def pause(self) -> None: ...

    @command(timeout=0.001)
    async def dawdle(self) -> None:
        await asyncio.Event().wait()


@pytest.fixture
async def thing() -> Thing:
    return Thing()


async def began(thing: Thing) -> None:
    async with asyncio.timeout(60):
        await thing.begun.wait()


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
    class Device(Component):
        """Connects when it is let, as often as it takes."""

        tempo: int = parameter(60)

        def __init__(self, *outcomes: Exception | None) -> None:
            self.outcomes = list(outcomes)
            self.calls: list[str] = []
            self.started = asyncio.Event()

        async def connect(self) -> None:
            self.calls.append("connect")
            outcome = self.outcomes.pop(0)
            if outcome is not None:
                raise outcome

        async def disconnect(self) -> None:
            self.calls.append("disconnect")

        @command
        async def start(self) -> None:
            self.calls.append("start")
            self.started.set()
            await asyncio.Event().wait()

        @event
        def beat(self) -> None: ...

    async def test_uninitialized_until_it_is_connected(self) -> None:
        device = self.Device(None)
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
        device = self.Device(error, None)
        faults: list[ErrorType] = []
        device.report = lambda kind, _description: faults.append(kind)
        assert not await device.bring_up()
        assert device.status.value == "ERROR"
        assert faults == [ErrorType.COMPONENT_INTERNAL_ERROR] * reported
        assert str(error) in caplog.text
        assert await device.bring_up()
        assert device.status.value == "READY"

    async def test_what_was_connected_is_let_go(self) -> None:
        device = self.Device(None)
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
        device = self.Device(OSError("no"))
        await device.take_down()
        await device.bring_up()
        await device.take_down()
        assert device.calls == ["connect"]

    @pytest.mark.parametrize("stuck", [True, False])
    async def test_a_disconnect_that_fails_or_takes_too_long_is_over_in_time(
        self, stuck: bool, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        class Clinging(self.Device):  # type: ignore[name-defined, misc]
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


class TestMessages:
    async def test_a_command_has_the_time_of_its_profile(self, thing: Thing) -> None:
        faults: list[tuple[ErrorType, str]] = []
        thing.report = lambda kind, description: faults.append((kind, description))
        with pytest.raises(TimedOut):
            await thing.run("dawdle", ())
        assert thing.status.value == "READY"
        assert faults == [(ErrorType.COMPONENT_NOT_RESPONDING, "thing: dawdle took longer than 1 ms")]

    async def test_a_time_out_inside_a_command_is_its_own_failure(self) -> None:
        class Slow(Thing):
            async def pause(self) -> None:
                raise TimeoutError("of something else")

        with pytest.raises(ComponentFailed, match="of something else"):
            await Slow().run("pause", ())

    async def test_a_bug_is_the_components_failure(self) -> None:
        class Broken(Thing):
            async def shape(self) -> str:
                raise ZeroDivisionError("a bug")

        with pytest.raises(ComponentFailed, match="crash"):
            await Lamp().run("crash", ())
        with pytest.raises(ComponentFailed, match="shape"):
            await Broken().ask("shape")

    async def test_a_failure_keeps_its_kind(self) -> None:
        class Refusing(Thing):
            async def shape(self) -> str:
                raise BadParameter("no")

        with pytest.raises(TimedOut):
            await Lamp().run("time_out", ())
        with pytest.raises(BadParameter):
            await Refusing().ask("shape")

    async def test_an_unknown_command_or_query(self, thing: Thing) -> None:
        with pytest.raises(Unsupported):
            await thing.run("fly", ())
        with pytest.raises(Unsupported):
            await thing.ask("fly")

    async def test_arguments_arrive_as_values_and_results_leave_as_text(self) -> None:
        class Sum(Payload):
            total: float
            parts: tuple[int, ...]
            note: str | None = None

        class Adder(Component):
            @command
            async def add(self, parts: tuple[int, ...], factor: float = 0.5, at: datetime | None = None) -> Sum:
                return Sum(total=sum(parts) * factor, parts=parts, note=None if at is None else f"{at:%Y}")

        adder = Adder()
        assert await adder.run("add", (argument("parts", "[1, 2]"),)) == (
            Result(name="total", data_type_ref="double", value="1.5"),
            Result(name="parts", data_type_ref="int[]", value="[1, 2]"),
        )
        given = (argument("parts", "[]"), argument("factor", "2e0"), argument("at", "2026-11-21T00:00:00Z"))
        assert (await adder.run("add", given))[2].value == "2026"
        with pytest.raises(BadParameter, match="parts"):
            await adder.run("add", ())

    @pytest.mark.parametrize("returned", [None, "many", float("nan"), float("inf"), [1.0]])
    async def test_a_result_that_is_not_what_was_declared_is_a_bug(self, returned: Any) -> None:
        class Scale(Component):
            @query
            async def weight(self) -> float:
                return returned  # type: ignore[no-any-return]

        with pytest.raises(ComponentFailed, match="weight failed"):
            await Scale().ask("weight")

    async def test_a_moment_without_time_zone_is_a_bug(self) -> None:
        class Sighting(Payload):
            at: datetime

        class Clock(Component):
            @query
            async def time(self) -> datetime:
                return datetime(2026, 6, 1)

            @query
            async def sighting(self) -> Sighting:
                return Sighting(at=datetime(2026, 6, 1))

            @event
            def struck(self, at: datetime) -> None: ...

        clock = Clock()
        for name in ("time", "sighting"):
            with pytest.raises(ComponentFailed, match=r"a moment needs a time zone, as in datetime.now\(UTC\)"):
                await clock.ask(name)
        with pytest.raises(ValueError, match="at: a moment needs a time zone"):
            clock.struck(datetime(2026, 6, 1))

    async def test_nothing_and_a_payload_are_what_was_declared_too(self) -> None:
        class Two(Payload):
            one: int

        class Wrong(Component):
            @command
            async def nothing(self) -> None:
                return 5  # type: ignore[return-value]

            @command
            async def two(self) -> Two:
                return {"one": 1}  # type: ignore[return-value]

        for name in ("nothing", "two"):
            with pytest.raises(ComponentFailed, match="declared"):
                await Wrong().run(name, ())

    async def test_limits_of_arguments_are_kept(self) -> None:
        class Dimmer(Component):
            @command
            async def dim(self, level: Annotated[int, Field(ge=0, le=10)]) -> None: ...

        assert await Dimmer().run("dim", (argument("level", "10"),)) == ()
        for level in ("11", "-1", "much"):
            with pytest.raises(BadParameter, match="level"):
                await Dimmer().run("dim", (argument("level", level),))


class TestParameters:
    async def test_they_start_with_their_defaults(self) -> None:
        stored = await Lamp().ask("get_parameter")
        assert {(p.name, p.data_type_ref, p.value) for p in stored} == {
            ("colour", "string", "white"),
            ("level", "int", "5"),
        }

    async def test_only_parameters_that_have_a_value_are_told(self) -> None:
        lamp = Lamp()
        await lamp.run("set_parameter", (argument("colour", ""),))
        assert [p.name for p in await lamp.ask("get_parameter")] == ["level"]

    async def test_attribute_and_store_are_one(self) -> None:
        lamp, other = Lamp(), Lamp()
        await lamp.run("set_parameter", (argument("level", "-0"),))
        assert (lamp.level, other.level) == (0, 5)
        assert (await lamp.ask("get_parameter"))[1].value == "-0"
        lamp.level = 7
        assert (await lamp.ask("get_parameter"))[1].value == "7"
        assert lamp.parameters == {"colour": "white", "level": 7}
        assert len(lamp.parameters) == 2
        with pytest.raises(ValueError, match="level"):
            lamp.level = "much"  # type: ignore[assignment]

    async def test_a_refused_value_changes_none(self) -> None:
        class Picky(Lamp):
            def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
                if changes.get("colour") == "beige":
                    raise BadParameter("not beige")
                return {name: value.lower() if name == "colour" else value for name, value in changes.items()}

        lamp = Picky()
        with pytest.raises(BadParameter):
            await lamp.run("set_parameter", (argument("level", "9"), argument("colour", "beige")))
        assert lamp.parameters == {"colour": "white", "level": 5}
        await lamp.run("set_parameter", (argument("colour", "RED"), argument("level", "8")))
        assert (lamp.colour, lamp.level) == ("red", 8)
        assert (await lamp.ask("get_parameter"))[0].value == "red"

    async def test_limits_and_parameters_that_are_only_read(self) -> None:
        class Radio(Component):
            volume: Annotated[int, Field(ge=0, le=100)] = parameter(50)
            stations: tuple[str, ...] = parameter(("one",), read_only=True)

        radio = Radio()
        for name, value in (("volume", "101"), ("stations", '["two"]'), ("pitch", "1")):
            with pytest.raises(BadParameter, match=name):
                await radio.run("set_parameter", (argument("volume", "1"), argument(name, value))[name == "volume" :])
        assert radio.volume == 50
        radio.stations = ("two",)
        assert (await radio.ask("get_parameter"))[1].value == '["two"]'
        with pytest.raises(ValueError, match="volume"):
            radio.volume = 101

    async def test_what_the_standard_lets_be_read_stays_so_in_a_subclass(self) -> None:
        class Hands(GestureRecognition):
            recognizable_gestures: tuple[str, ...] | None = parameter(("wave",))

        class Loud(Component):
            volume: Annotated[int, Data(description="how loud")] = parameter(50, read_only=True)

        for component, name, value in ((Hands(), "recognizable_gestures", '["nod"]'), (Loud(), "volume", "1")):
            with pytest.raises(BadParameter, match=f"{name} can only be read"):
                await component.run("set_parameter", (argument(name, value),))
            (profile,) = component.profile.parameter_profiles
            assert profile.description.endswith("; read only")

    async def test_what_a_component_accepts_fits_too(self) -> None:
        class Careless(Lamp):
            def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
                return {"level": "high"}

        with pytest.raises(BadParameter, match="level"):
            await Careless().run("set_parameter", (argument("level", "1"),))


class TestEvents:
    async def test_one_before_anybody_can_listen_is_dropped(self, caplog: pytest.LogCaptureFixture) -> None:
        with caplog.at_level(logging.DEBUG):
            Bell().ring("ding")
        assert not caplog.records

    async def test_one_that_tells_nothing_but_itself(self) -> None:
        device = TestLife.Device()
        heard: list[tuple[str, tuple[Result, ...]]] = []
        device.emit = lambda kind, results: heard.append((kind, results))
        device.beat()
        assert heard == [("beat", ())]

    async def test_a_call_with_wrong_values_is_the_callers_mistake(self) -> None:
        bell = Bell()
        heard: list[object] = []
        bell.emit = lambda kind, _results: heard.append(kind)
        with pytest.raises(TypeError, match="tune"):
            bell.rang()  # type: ignore[call-arg]
        with pytest.raises(ValueError, match="tune"):
            bell.rang(5)  # type: ignore[arg-type]
        assert heard == []

    async def test_one_of_another_thread_arrives_in_the_loop(self) -> None:
        bell = Bell()
        heard: asyncio.Queue[tuple[str, int]] = asyncio.Queue()
        bell.emit = lambda _kind, results: heard.put_nowait((results[0].value, threading.get_ident()))
        await bell.bring_up()
        await asyncio.to_thread(bell.ring, "ding")
        async with asyncio.timeout(60):
            assert await heard.get() == ("ding", threading.get_ident())

    async def test_so_does_a_report(self) -> None:
        bell = Bell()
        heard: asyncio.Queue[tuple[ErrorType, str, int]] = asyncio.Queue()
        bell.report = lambda kind, what: heard.put_nowait((kind, what, threading.get_ident()))
        await bell.bring_up()
        await asyncio.to_thread(bell.report, ErrorType.USER_DEFINED_ERROR, "cracked")
        async with asyncio.timeout(60):
            assert await heard.get() == (ErrorType.USER_DEFINED_ERROR, "cracked", threading.get_ident())

    def test_one_of_another_thread_after_the_loop_has_ended_is_dropped(self) -> None:
        bell = Bell()
        asyncio.run(bell.bring_up())
        bell.ring("ding")

    async def test_a_moment_that_is_not_said_is_now(self) -> None:
        detector = PersonDetection()
        heard: list[dict[str, str]] = []
        detector.emit = lambda _kind, results: heard.append({result.name: result.value for result in results})
        detector.person_detected(2)
        detector.person_detected(3, datetime(2026, 1, 1, tzinfo=UTC))
        assert [told["number"] for told in heard] == ["2", "3"]
        assert abs(datetime.fromisoformat(heard[0]["timestamp"]) - datetime.now(UTC)) < timedelta(minutes=1)
        assert heard[1]["timestamp"].startswith("2026-01-01T00:00:00")


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
    with pytest.raises(TypeError, match="to be extended"):
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
        """An own task of the component's that is cancelled does not cancel whoever asked: they are owed an answer."""
        clumsy = self.Clumsy()
        clumsy.work.cancel()
        for name in ("wait", "start"):
            with pytest.raises(Aborted):
                await clumsy.run(name, ())
        with pytest.raises(Aborted, match="what waited waited for was cancelled"):
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
