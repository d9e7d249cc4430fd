"""Commands, queries, parameters and events of a component in this process."""

import asyncio
import logging
import threading
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any

import pytest
from pydantic import Field

from openrois.adapter.components import GestureRecognition, PersonDetection
from openrois.catalog.payload import Data, Payload
from openrois.component.authoring.marks import command, event, query
from openrois.component.authoring.parameters import parameter
from openrois.component.component import Component
from openrois.errors import BadParameter, ComponentFailed, TimedOut, Unsupported
from openrois.types.codes import ErrorType
from openrois.types.messages import Result
from tests.support.components import Bell, Lamp
from tests.support.thing import Device, Thing, argument


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
            with pytest.raises(BadParameter, match=f"{name} is read-only"):
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
        device = Device()
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
