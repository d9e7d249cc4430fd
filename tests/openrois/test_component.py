"""What every component in this process does by itself. What it shares with remote ones is in `tests/contract`."""

import asyncio
import logging

import pytest

from openrois.component import COMMON_QUERIES, Component, check_arguments, command, parameter_profile, query
from openrois.errors import Aborted, BadParameter, ComponentFailed, TimedOut, Unsupported
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument, Result
from openrois.types.profiles import CommandMessageProfile, HRIComponentProfile, QueryMessageProfile, RoISIdentifier
from tests.support.components import Bell, Lamp


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="ignored", value=value)


def profile(*commands: CommandMessageProfile) -> HRIComponentProfile:
    return HRIComponentProfile(
        identifier=RoISIdentifier(code="urn"),
        name="thing",
        command_profiles=commands,
        query_profiles=(*COMMON_QUERIES, QueryMessageProfile(name="shape")),
    )


COMMANDS = ("start", "stop", "suspend", "resume")


class Thing(Component):
    """Its condition and what `start` and `dawdle` do are set by the test."""

    def __init__(self) -> None:
        super().__init__(
            profile(
                *(CommandMessageProfile(name=name) for name in COMMANDS),
                CommandMessageProfile(name="dawdle", timeout=1),
            )
        )
        self.is_in = ComponentStatus.READY
        self.starts: list[str] = []
        self.begun = asyncio.Event()
        self.may_end = asyncio.Event()
        self.stopped = 0

    def condition(self) -> ComponentStatus:
        return self.is_in

    @query("shape")
    async def shape(self) -> tuple[Result, ...]:
        return (Result(name="shape", data_type_ref="string", value="round"),)

    @command("start")
    async def start(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        self.starts.append("begins")
        self.begun.set()
        try:
            await self.may_end.wait()
        finally:
            self.starts.append("ends")
        return ()

    @command("stop")
    async def stop(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        self.stopped += 1
        return ()

    @command("suspend", "resume")
    async def pause(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        return ()

    @command("dawdle")
    async def dawdle(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        await asyncio.Event().wait()
        return ()


@pytest.fixture
async def thing() -> Thing:
    return Thing()


async def began(thing: Thing) -> None:
    async with asyncio.timeout(5):
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

    async def test_trouble_shows_while_a_command_runs(self, thing: Thing) -> None:
        running = asyncio.ensure_future(thing.run("start", ()))
        await began(thing)
        thing.is_in = ComponentStatus.ERROR
        assert thing.status.value == "ERROR"
        thing.may_end.set()
        await running

    async def test_a_component_may_answer_its_status_itself(self) -> None:
        class Own(Thing):
            @query("component_status")
            async def own_status(self) -> tuple[Result, ...]:
                return (Result(name="status", data_type_ref="Component_Status", value="WARNING"),)

        assert (await Own().ask("component_status"))[0].value == "WARNING"


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

    async def test_a_start_that_fails_when_its_caller_is_cancelled_is_not_forgotten(self, thing: Thing) -> None:
        class Stubborn(Thing):
            @command("start")
            async def start(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
                self.begun.set()
                try:
                    await asyncio.Event().wait()
                except asyncio.CancelledError:
                    raise ComponentFailed("no") from None
                return ()

        stubborn = Stubborn()
        running = asyncio.ensure_future(stubborn.run("start", ()))
        await began(stubborn)
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running


class TestCommands:
    async def test_one_method_may_run_several(self, thing: Thing) -> None:
        assert await thing.run("suspend", ()) == await thing.run("resume", ()) == ()

    async def test_a_profile_that_offers_more_than_the_class_does_is_a_mistake(self) -> None:
        class Empty(Component):
            pass

        with pytest.raises(TypeError, match="fly, shape, start"):
            Empty(profile(*(CommandMessageProfile(name=name) for name in ("fly", "start", "stop"))))

    async def test_a_command_has_the_time_of_its_profile(self, thing: Thing) -> None:
        with pytest.raises(TimedOut):
            await thing.run("dawdle", ())
        assert thing.status.value == "READY"

    async def test_a_time_out_inside_a_command_is_its_own_failure(self, thing: Thing) -> None:
        class Slow(Thing):
            async def pause(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
                raise TimeoutError("of something else")

        with pytest.raises(ComponentFailed, match="of something else"):
            await Slow().run("suspend", ())

    async def test_a_bug_is_the_components_failure(self) -> None:
        with pytest.raises(ComponentFailed, match="crash"):
            await Lamp().run("crash", ())

        class Broken(Thing):
            async def shape(self) -> tuple[Result, ...]:
                raise ZeroDivisionError("a bug")

        with pytest.raises(ComponentFailed, match="shape"):
            await Broken().ask("shape")

    async def test_a_failure_keeps_its_kind(self) -> None:
        with pytest.raises(TimedOut):
            await Lamp().run("time_out", ())

        class Refusing(Thing):
            async def shape(self) -> tuple[Result, ...]:
                raise BadParameter("no")

        with pytest.raises(BadParameter):
            await Refusing().ask("shape")

    async def test_an_unknown_command_or_query(self, thing: Thing) -> None:
        with pytest.raises(Unsupported):
            await thing.run("fly", ())
        with pytest.raises(Unsupported):
            await thing.ask("fly")

    async def test_marks_are_inherited_and_can_be_overridden(self) -> None:
        class Derived(Thing):
            async def start(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
                return (Result(name="x", data_type_ref="string", value="derived"),)

        (result,) = await Derived().run("start", ())
        assert result.value == "derived"


class TestParameters:
    async def test_they_start_with_the_defaults_of_the_profile(self) -> None:
        stored = await Lamp().ask("get_parameter")
        assert {(p.name, p.data_type_ref, p.value) for p in stored} == {
            ("colour", "string", "white"),
            ("level", "int", "5"),
        }

    async def test_only_parameters_that_have_a_value_are_told(self) -> None:
        lamp = Lamp()
        await lamp.run("set_parameter", (argument("colour", ""),))
        assert [p.name for p in await lamp.ask("get_parameter")] == ["level"]

    async def test_a_refused_value_changes_none(self) -> None:
        class Picky(Lamp):
            def accept_parameters(self, values: dict[str, str]) -> dict[str, str]:
                if values.get("colour") == "beige":
                    raise BadParameter("not beige")
                return {name: value.lower() for name, value in values.items()}

        lamp = Picky()
        with pytest.raises(BadParameter):
            await lamp.run("set_parameter", (argument("level", "9"), argument("colour", "beige")))
        assert lamp.parameters == {"colour": "white", "level": "5"}
        await lamp.run("set_parameter", (argument("colour", "RED"),))
        assert lamp.parameters["colour"] == "red"


class TestArguments:
    PROFILES = (parameter_profile("times", "int"), parameter_profile("note", "string"))

    def test_values_by_name(self) -> None:
        assert check_arguments(self.PROFILES, (argument("note", "x"), argument("times", "3"))) == {
            "note": "x",
            "times": "3",
        }
        assert check_arguments(self.PROFILES, ()) == {}

    @pytest.mark.parametrize(
        "arguments",
        [
            (argument("colour", "x"),),
            (argument("times", "many"),),
            (argument("times", "1"), argument("times", "1")),
        ],
    )
    def test_what_does_not_fit(self, arguments: tuple[Argument, ...]) -> None:
        with pytest.raises(BadParameter):
            check_arguments(self.PROFILES, arguments)

    def test_a_component_without_arguments_says_so(self) -> None:
        with pytest.raises(BadParameter, match="none"):
            check_arguments((), (argument("x", "y"),))


async def test_an_event_before_anybody_can_listen_is_dropped(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG):
        Bell().ring("ding")
    assert not caplog.records
