"""What is read from a component class: its type and profile, and the error for its author where that cannot be."""

from collections.abc import Callable
from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any, Literal

import pytest
from pydantic import Field

from openrois.adapter import (
    Component,
    ComponentStatus,
    Data,
    Payload,
    command,
    components,
    event,
    optional,
    parameter,
    query,
)
from openrois.catalog.actuation import AvailableVoicesResult
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.streaming import ConnectStreamResults
from openrois.catalog.system_information import EngineStatusResult
from openrois.types.codes import ComponentFunction
from openrois.types.profiles import ParameterProfile


class Colour(StrEnum):
    RED = "red"
    BLUE = "blue"


class Reading(Payload):
    """What a sensor measured."""

    celsius: Annotated[float, Data(description="in the shade")]
    at: datetime


class Weather(Component, authority="Example", function="sensing"):
    """Tells the weather. It cannot change it."""

    interval: Annotated[int, Field(ge=1)] = parameter(60, description="seconds")
    colour: Colour = parameter(Colour.BLUE)
    mode: Literal["fast", "exact"] = parameter("fast")
    places: tuple[str, ...] | None = parameter(None)

    @command(name="calibrate_now", timeout=2.5)
    async def calibrate(self, offset: float, label: str | None = None, colours: tuple[Colour, ...] = ()) -> None:
        """Set the zero. Needs a minute.

        Args:
            offset: degrees that are added
                from now on.
            label (str): why
        """

    @query
    async def reading(self) -> Reading: ...  # type: ignore[empty-body]

    @query(result="percent")
    async def humidity(self) -> int | None: ...

    @event
    def changed(self, status: ComponentStatus, reasons: tuple[str, ...] = ()) -> None:
        """The weather has changed."""

    @command
    async def start(self) -> None: ...


def spelled(profiles: tuple[ParameterProfile, ...]) -> list[tuple[str, str, str, str]]:
    return [(p.name, p.data_type_ref.code, p.default_value, p.description) for p in profiles]


class TestWhatIsRead:
    def test_the_type(self) -> None:
        kind = Weather.component_type
        assert (kind.code, kind.name, kind.authority, kind.function) == (
            "Weather",
            "weather",
            "Example",
            ComponentFunction.SENSING,
        )
        assert kind.urn == "urn:x-rois:def:component:Example::Weather"
        assert kind.description == "Tells the weather."
        assert [included.code for included in kind.includes] == ["RoISCommon"]
        assert kind.definition().sub_component_profiles == (ROIS_COMMON.urn,)

    def test_commands_those_of_rois_common_first(self) -> None:
        start, calibrate = Weather("w").profile.command_profiles
        assert (start.name, start.timeout, start.arguments, start.results) == ("start", None, (), ())
        assert (calibrate.name, calibrate.timeout) == ("calibrate_now", 2500)
        assert spelled(calibrate.arguments) == [
            ("offset", "double", "", "degrees that are added from now on"),
            ("label", "string", "", "why"),
            ("colours", "string[]", "[]", ""),
        ]
        assert [each.description for each in Weather.component_type.commands] == ["Set the zero."]

    def test_queries(self) -> None:
        status, reading, humidity = Weather("w").profile.query_profiles
        assert status == ROIS_COMMON.queries[0].profile()
        assert spelled(reading.results) == [("celsius", "double", "", "in the shade"), ("at", "DateTime", "", "")]
        assert spelled(humidity.results) == [("percent", "int", "", "")]

    def test_events_and_parameters(self) -> None:
        profile = Weather("w").profile
        (changed,) = profile.event_profiles
        assert spelled(changed.results) == [("status", "Component_Status", "", ""), ("reasons", "string[]", "[]", "")]
        assert spelled(profile.parameter_profiles) == [
            ("interval", "int", "60", "seconds"),
            ("colour", "string", "blue", ""),
            ("mode", "string", "fast", ""),
            ("places", "string[]", "", ""),
        ]

    def test_names(self) -> None:
        assert Weather().name == "weather"
        assert Weather("roof").profile.name == "roof"

        class PanTiltUnit(Component):
            pass

        assert PanTiltUnit().name == "pan_tilt_unit"
        assert PanTiltUnit.component_type.urn == "urn:x-rois:def:component:local::PanTiltUnit"
        assert PanTiltUnit.component_type.function is None

    def test_a_subclass_is_of_the_same_type_unless_it_says_so(self) -> None:
        class Roof(Weather):
            async def humidity(self) -> int | None:
                return 5

        class Cellar(Weather, code="Cellar"):
            interval: int = parameter(5)

        assert Roof.component_type.urn == Weather.component_type.urn
        assert Roof().profile.query_profiles == Weather().profile.query_profiles
        assert Cellar.component_type.urn == "urn:x-rois:def:component:Example::Cellar"
        assert Cellar.component_type.function is ComponentFunction.SENSING
        assert spelled(Cellar().profile.parameter_profiles)[0] == ("interval", "int", "5", "")

    def test_what_an_annotation_says_itself_counts(self) -> None:
        class Dial(Component):
            step: Annotated[int, Data(code="long", description="ticks")] = parameter(1, description="something else")

            @command
            async def turn(self, by: Annotated[int, Data(description="ticks")]) -> None:
                """Turn it.

                Args:
                    by: something else
                """

        profile = Dial().profile
        assert spelled(profile.parameter_profiles) == [("step", "long", "1", "ticks")]
        assert spelled(profile.command_profiles[0].arguments) == [("by", "int", "", "ticks")]

    def test_text_annotations_are_read_as_types(self) -> None:
        class Late(Component):
            level: "int" = parameter(3)

            @command
            async def look(self, x: "float") -> "Reading": ...  # type: ignore[empty-body]

        (look,) = Late().profile.command_profiles
        assert [each.data_type_ref.code for each in (*look.arguments, *look.results)] == [
            "double",
            "double",
            "DateTime",
        ]


class TestBasicComponents:
    @pytest.mark.parametrize("kind", BASIC_COMPONENTS, ids=lambda kind: kind.code)
    def test_a_class_has_the_parameters_and_events_of_its_type(self, kind: Any) -> None:
        made = getattr(components, kind.code)()
        assert made.name == kind.name
        assert made.profile.component_type == kind.urn
        assert made.profile.function is kind.function
        assert made.profile.parameter_profiles == kind.profile().parameter_profiles
        assert made.profile.event_profiles == kind.profile().event_profiles
        assert made.profile.command_profiles == ()
        assert {query.name for query in made.profile.query_profiles} == (
            {"component_status"} if kind.code != "SystemInformation" else set()
        )

    def test_what_is_written_is_there_as_the_standard_has_it(self) -> None:
        class Voice(components.SpeechSynthesis):
            volume: Annotated[int, Field(le=80)] = parameter(40)

            async def available_voices(self) -> tuple[str, ...]:
                return ()

            async def stop(self) -> None: ...

            @command(timeout=9)
            async def start(self) -> None: ...

            @command
            async def whisper(self) -> None: ...

        profile = Voice().profile
        assert [each.name for each in profile.command_profiles] == ["start", "stop", "whisper"]
        assert [each.timeout for each in profile.command_profiles] == [9000, None, None]
        assert profile.query_profiles[1].results == AvailableVoicesResult.profiles()
        assert spelled(profile.parameter_profiles)[2] == ("volume", "int", "40", "how loud, 0 to 100")

    def test_a_payload_of_the_standard_may_be_returned_as_it_is(self) -> None:
        class Camera(components.VideoStreaming):
            @command
            async def connect_stream(self) -> ConnectStreamResults:  # type: ignore[override]
                return ConnectStreamResults(stream_id="s")

        (connect,) = Camera().profile.command_profiles
        assert connect.results == ConnectStreamResults.profiles()

    def test_what_a_class_does_without(self) -> None:
        class Blind(components.PersonLocalization, omit=("detection_threshold", "person_localized")):
            pass

        class Blinder(Blind, omit=("minimum_interval",)):
            pass

        blind = Blind()
        assert [each.name for each in blind.profile.parameter_profiles] == ["minimum_interval"]
        assert blind.profile.event_profiles == ()
        assert Blinder().profile.parameter_profiles == ()
        blind.person_localized((), ())

    def test_a_class_of_the_standard_can_be_told_its_function(self) -> None:
        class Here(components.SystemInformation, function="sensing"):
            async def engine_status(self) -> EngineStatusResult:
                return EngineStatusResult(status=ComponentStatus.READY)

        assert Here().profile.function is ComponentFunction.SENSING
        assert [each.name for each in Here().profile.query_profiles] == ["engine_status"]


def unknown_type() -> None:
    class Wrong(Component):
        @command
        async def paint(self, picture: bytes) -> None: ...


def unknown_result() -> None:
    class Wrong(Component):
        @query
        async def pair(self) -> tuple[int, str]: ...  # type: ignore[empty-body]


def unknown_parameter() -> None:
    class Wrong(Component):
        table: dict[str, int] = parameter({})


def changeable_parameter() -> None:
    class Wrong(Component):
        names: list[str] = parameter([])


def parameter_without_type() -> None:
    class Wrong(Component):
        level = parameter(5)


def argument_without_type() -> None:
    class Wrong(Component):
        @command
        async def dim(self, level) -> None: ...  # type: ignore[no-untyped-def]


def nothing_said_of_results() -> None:
    class Wrong(Component):
        @command
        async def dim(self): ...  # type: ignore[no-untyped-def]


def any_number_of_arguments() -> None:
    class Wrong(Component):
        @command
        async def dim(self, *levels: int) -> None: ...


def query_with_arguments() -> None:
    class Wrong(Component):
        @query
        async def power(self, unit: str) -> float: ...  # type: ignore[empty-body]


def command_that_is_not_async() -> None:
    class Wrong(Component):
        @command  # type: ignore[type-var]
        def dim(self) -> None: ...


def override_that_is_not_async() -> None:
    class Wrong(components.Navigation):
        def start(self) -> None: ...  # type: ignore[override]


def event_that_is_async() -> None:
    class Wrong(Component):
        @event  # type: ignore[type-var]
        async def dimmed(self) -> None: ...


def event_that_returns() -> None:
    class Wrong(Component):
        @event  # type: ignore[type-var]
        def dimmed(self) -> int: ...  # type: ignore[empty-body]


def event_overridden_without_decorator() -> None:
    class Wrong(components.Navigation):
        def reached_target(self, target: str, is_final_target: bool) -> None: ...


def parameter_overridden_by_something_else() -> None:
    class Wrong(components.Navigation):
        time_limit = 5


def two_of_one_name() -> None:
    class Wrong(Component):
        @command
        async def dim(self) -> None: ...

        @command(name="dim")
        async def dim_again(self) -> None: ...


def name_of_the_components_own() -> None:
    class Wrong(Component):
        @command  # type: ignore[misc]
        async def run(self) -> None: ...  # type: ignore[override]


def parameter_of_the_components_own() -> None:
    class Wrong(Component):
        status: str = parameter("fine")  # type: ignore[assignment]


def everybodys_command() -> None:
    class Wrong(Component):
        @command
        async def set_parameter(self) -> None: ...


def name_with_a_slash() -> None:
    class Wrong(Component):
        @command(name="a/b")
        async def dim(self) -> None: ...


def name_that_a_payload_has() -> None:
    class Wrong(Component):
        @command
        async def dim(self, texts: str) -> None: ...


def default_that_does_not_fit() -> None:
    class Wrong(Component):
        @command
        async def dim(self, level: int = "low") -> None: ...  # type: ignore[assignment]


def parameter_default_that_does_not_fit() -> None:
    class Wrong(Component):
        level: Annotated[int, Field(le=10)] = parameter(11)


def start_with_arguments() -> None:
    class Wrong(Component):
        @command
        async def start(self, speed: int) -> None: ...


def start_with_results() -> None:
    class Wrong(Component):
        @command
        async def start(self) -> int: ...  # type: ignore[empty-body]


def payload_where_a_value_is_due() -> None:
    class Wrong(components.SpeechSynthesis):
        async def available_voices(self) -> Reading: ...  # type: ignore[override, empty-body]


def value_of_another_type() -> None:
    class Wrong(components.SpeechSynthesis):
        async def available_voices(self) -> tuple[int, ...]: ...  # type: ignore[override, empty-body]


def value_where_several_are_due() -> None:
    class Wrong(components.SystemInformation):
        async def engine_status(self) -> str: ...  # type: ignore[override, empty-body]


def event_with_other_values() -> None:
    class Wrong(components.Navigation):
        @event
        def reached_target(self, target: str) -> None: ...  # type: ignore[override]


def parameter_of_another_type() -> None:
    class Wrong(components.Navigation):
        time_limit: str = parameter("long")  # type: ignore[assignment]


def omitting_what_is_not_there() -> None:
    class Wrong(components.Navigation, omit=("wings",)):
        pass


def omitting_what_is_required() -> None:
    class Wrong(components.Navigation, omit=("target_positions",)):
        pass


def optional_and_no_message() -> None:
    class Wrong(Component):
        @optional
        async def dim(self) -> None: ...


def no_time_at_all() -> None:
    class Wrong(Component):
        @command(timeout=0)
        async def dim(self) -> None: ...


def type_that_is_not_known_yet() -> None:
    class Wrong(Component):
        level: "Later" = parameter(None)  # type: ignore[name-defined] # noqa: F821


def argument_type_that_is_not_known_yet() -> None:
    class Wrong(Component):
        @command
        async def dim(self, level: "Later") -> None: ...  # type: ignore[name-defined] # noqa: F821


@pytest.mark.parametrize(
    ("write", "told"),
    [
        (unknown_type, r"Wrong.paint: picture: bytes has no text on the wire; write int, float"),
        (unknown_result, r"Wrong.pair: pair: .* or a Payload for several results"),
        (unknown_parameter, r"Wrong.table: dict.* has no text on the wire"),
        (changeable_parameter, r"Wrong.names: write `tuple"),
        (parameter_without_type, r"Wrong.level: write its type, such as `level: int"),
        (argument_without_type, r"Wrong.dim: write the type of level"),
        (nothing_said_of_results, r"Wrong.dim: write what it returns, `-> None`"),
        (any_number_of_arguments, r"Wrong.dim: \*levels: int cannot stand on the wire"),
        (query_with_arguments, r"Wrong.power: a query takes no arguments"),
        (command_that_is_not_async, r"Wrong.dim is a command: write `async def`"),
        (override_that_is_not_async, r"Wrong.start overrides a command: write `async def start`"),
        (event_that_is_async, r"Wrong.dimmed is an event: write `def`"),
        (event_that_returns, r"Wrong.dimmed: announcing an event gives nothing back"),
        (event_overridden_without_decorator, r"Wrong.reached_target overrides an event: write `@event`"),
        (parameter_overridden_by_something_else, r"Wrong.time_limit overrides a parameter"),
        (two_of_one_name, r"Wrong.dim_again: dim is the command 'dim' already"),
        (name_of_the_components_own, r"Wrong.run: .* write `@command\(name='run'\)`"),
        (parameter_of_the_components_own, r"Wrong.status: 'status' cannot be the name of a parameter"),
        (everybodys_command, r"Wrong.set_parameter: every component has 'set_parameter'"),
        (name_with_a_slash, r"Wrong.dim: 'a/b' cannot be the name of a message"),
        (name_that_a_payload_has, r"Wrong.dim: 'texts' cannot be the name of a value"),
        (default_that_does_not_fit, r"Wrong.dim: the default of level"),
        (parameter_default_that_does_not_fit, r"the default of level: .* less than or equal to 10"),
        (start_with_arguments, r"Wrong.start: the standard's start takes nothing"),
        (start_with_results, r"Wrong.start: write `-> None`"),
        (payload_where_a_value_is_due, r"Wrong.available_voices: write `-> AvailableVoicesResult`"),
        (value_of_another_type, r"Wrong.available_voices: available_voices returns a value of type string\[\]"),
        (value_where_several_are_due, r"write `-> EngineStatusResult`, which has status, operable_time"),
        (event_with_other_values, r"the standard's reached_target takes target: string, is_final_target: bool"),
        (parameter_of_another_type, r"Wrong.time_limit: in Navigation it is of type int, not string"),
        (omitting_what_is_not_there, r"Wrong omits 'wings', which Navigation has not"),
        (omitting_what_is_required, r"Wrong omits 'target_positions', which Navigation requires"),
        (optional_and_no_message, r"Wrong.dim is no message: write `@command` or `@query` below"),
        (no_time_at_all, r"a timeout of 0 s"),
        (type_that_is_not_known_yet, r"Wrong.level: name 'Later' is not defined"),
        (argument_type_that_is_not_known_yet, r"Wrong.dim: name 'Later' is not defined"),
    ],
    ids=lambda value: value.__name__ if callable(value) else "",
)
def test_what_cannot_be_is_a_type_error_that_says_what_to_write(write: Callable[[], None], told: str) -> None:
    with pytest.raises(TypeError, match=told):
        write()
