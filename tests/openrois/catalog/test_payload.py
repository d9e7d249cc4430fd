"""Payloads: Python objects on one side, text on the wire on the other, and nothing in between gets lost."""

from datetime import UTC, datetime
from enum import Enum, StrEnum
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import Field, model_validator

from openrois.catalog.actuation import NavigationParameters, ReachedTarget, SpeechSynthesisParameters
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON, ComponentStatusResult
from openrois.catalog.payload import Data, Payload, type_code
from openrois.catalog.sensing import PersonDetected, SpeechRecognitionParameters
from openrois.catalog.streaming import NotifyStreamStatus
from openrois.types.codes import ComponentStatus, StreamStatus
from openrois.types.messages import Argument, Parameter, Result
from openrois.types.values import check_value

NOON = datetime(2026, 6, 1, 12, tzinfo=UTC)
PAYLOADS = {
    f"{kind.code}.{payload.__name__}": payload
    for kind in (ROIS_COMMON, *BASIC_COMPONENTS)
    for payload in kind.payloads()
}


class Colour(StrEnum):
    RED = "red"


class Plain(Enum):
    RED = 1


class Everything(Payload):
    """Every type there is."""

    whole: int
    real: float
    truth: bool
    text: str
    moment: datetime
    status: ComponentStatus
    stream: StreamStatus
    colour: Colour
    choice: Literal["left", "right"]
    numbers: list[int]
    grid: tuple[tuple[float, ...], ...]
    moments: tuple[Annotated[datetime, Field()], ...]
    maybe: int | None = None


@pytest.mark.parametrize(
    ("annotation", "code"),
    [
        (int, "int"),
        (float, "double"),
        (bool, "bool"),
        (str, "string"),
        (datetime, "DateTime"),
        (ComponentStatus, "Component_Status"),
        (StreamStatus, "Stream_Status"),
        (Colour, "string"),
        (Literal["a", "b"], "string"),
        (int | None, "int"),
        (Annotated[int | None, Field()], "int"),
        (tuple[str, ...], "string[]"),
        (list[bool], "bool[]"),
        (tuple[tuple[int, ...], ...] | None, "int[][]"),
    ],
)
def test_types_have_codes(annotation: Any, code: str) -> None:
    assert type_code(annotation) == code


@pytest.mark.parametrize(
    "annotation",
    [bytes, dict[str, int], int | str, tuple[int, str], tuple[()], list, Plain, Literal[1], None, Any, set[int]],
)
def test_types_that_have_none(annotation: Any) -> None:
    with pytest.raises(TypeError, match="has no data_type_ref"):
        type_code(annotation)


@pytest.mark.parametrize("payload", PAYLOADS.values(), ids=PAYLOADS)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_what_is_written_is_read_back(payload: type[Payload], data: st.DataObject) -> None:
    built = data.draw(st.from_type(payload).filter(representable))
    for kind in (Result, Parameter, Argument):
        written = built.named(kind)
        assert payload.from_results(written) == built
        for each in written:
            check_value(each.data_type_ref, each.value)
            assert each.data_type_ref == payload.data()[each.name].code


def representable(payload: Payload) -> bool:
    """Tell whether values stay within the bounds of the wire: 20 digits, and offsets of time as ISO 8601 has them."""
    try:
        payload.texts()
    except ValueError:
        return False
    return True


@settings(deadline=None)
@given(st.builds(Everything, moments=st.lists(st.datetimes(timezones=st.just(UTC))).map(tuple)).filter(representable))
def test_every_type_is_read_back(built: Everything) -> None:
    assert Everything.from_texts(built.texts()) == built


def test_what_is_only_read_says_so_in_the_profile() -> None:
    class Radio(Payload):
        stations: Annotated[str | None, Data(description="what it receives", read_only=True)] = None
        band: Annotated[str | None, Data(read_only=True)] = None
        volume: Annotated[int, Data(description="how loud")] = 5

    assert [profile.description for profile in Radio.profiles()] == [
        "what it receives; read only",
        "read only",
        "how loud",
    ]


def test_profiles_say_name_type_default_and_description() -> None:
    profiles = {each.name: each for each in SpeechSynthesisParameters.profiles()}
    assert list(profiles) == ["speech_text", "ssml_text", "volume", "language", "character"]
    assert profiles["volume"].default_value == "50"
    assert profiles["volume"].data_type_ref.code == "int"
    assert profiles["volume"].description == "how loud, 0 to 100"
    assert profiles["speech_text"].default_value == ""
    assert SpeechRecognitionParameters.profiles()[0].default_value == '["ja"]'


def test_what_is_absent_is_not_sent() -> None:
    assert NavigationParameters().texts() == {"time_limit": "0", "routing_policy": "time"}
    assert NavigationParameters.from_texts({}) == NavigationParameters()
    told = NotifyStreamStatus(timestamp=NOON, status=StreamStatus.STREAMING_RUNNING)
    assert [(each.name, each.value) for each in told.named(Result)] == [
        ("timestamp", "2026-06-01T12:00:00+00:00"),
        ("status", "STREAMING_RUNNING"),
    ]


def test_names_that_it_does_not_have_are_passed_over() -> None:
    texts = {"target": "lobby", "is_final_target": "true", "mood": "good"}
    assert ReachedTarget.from_texts(texts) == ReachedTarget(target="lobby", is_final_target=True)


@pytest.mark.parametrize(
    ("payload", "texts", "sentence"),
    [
        (ReachedTarget, {"target": "x", "is_final_target": "yes"}, "is_final_target: 'yes' is not of type bool"),
        (ReachedTarget, {"is_final_target": "true"}, "target: Field required"),
        (PersonDetected, {"number": "two", "timestamp": "2026-06-01T12:00:00Z"}, "number: 'two' is not of type int"),
        (PersonDetected, {"number": "2", "timestamp": "noon"}, "timestamp: 'noon' is no date and time of ISO 8601"),
        (PersonDetected, {"number": "2", "timestamp": "1780315200"}, "timestamp: '1780315200' is no date"),
        (PersonDetected, {"number": "2", "timestamp": "2026-06-01"}, "timestamp: '2026-06-01' is no date and time"),
        (ComponentStatusResult, {"status": "ready"}, "status: 'ready' is not of type Component_Status"),
        (
            NotifyStreamStatus,
            {"timestamp": "2026-06-01T12:00:00Z", "status": "RUNNING"},
            "status: Input should be 'STREAMING_NOT_CONNECTED'",
        ),
        (NavigationParameters, {"target_positions": "lobby"}, "target_positions: 'lobby' is not a JSON array"),
        (NavigationParameters, {"target_positions": "[1]"}, "target_positions: an item of the array is not of type"),
    ],
)
def test_what_cannot_be_read_is_named(payload: type[Payload], texts: dict[str, str], sentence: str) -> None:
    with pytest.raises(ValueError) as raised:
        payload.from_texts(texts)
    assert str(raised.value).startswith(sentence)


def test_moments_in_lists_are_checked_too() -> None:
    class Log(Payload):
        """When it happened."""

        moments: list[datetime]

    assert Log.from_texts({"moments": '["2026-06-01T12:00:00Z"]'}) == Log(moments=[NOON])
    with pytest.raises(ValueError, match="moments: '0' is no date and time"):
        Log.from_texts({"moments": '["0"]'})


def test_a_moment_may_stay_text() -> None:
    class Log(Payload):
        """When it happened."""

        when: Annotated[str, Data("DateTime")]

    assert Log.from_texts({"when": "yesterday"}).when == "yesterday"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e308 * 10])
def test_what_has_no_text_is_not_sent(value: float) -> None:
    class Measure(Payload):
        """A number."""

        metres: float

    with pytest.raises(ValueError, match=r"metres: '(nan|inf)' is not of type double"):
        Measure(metres=value).texts()


def test_too_many_digits_are_not_sent() -> None:
    with pytest.raises(ValueError, match="number: a number of 67 bits is not of type int"):
        PersonDetected(number=10**20, timestamp=NOON).named(Result)


def test_a_rule_over_several_values_says_only_what_it_says() -> None:
    class Either(Payload):
        """One of two."""

        left: str | None = None
        right: str | None = None

        @model_validator(mode="after")
        def _one(self) -> "Either":
            if (self.left is None) == (self.right is None):
                raise ValueError("one of the two is needed")
            return self

    with pytest.raises(ValueError, match=r"^Value error, one of the two is needed$"):
        Either.from_texts({})


def test_a_value_without_a_code_is_named() -> None:
    class Raw(Payload):
        """What has no text."""

        octets: bytes

    with pytest.raises(TypeError, match=r"Raw\.octets: <class 'bytes'> has no data_type_ref"):
        Raw.profiles()


def test_a_default_that_cannot_be_written_is_named() -> None:
    class Wrong(Payload):
        """A default of another type."""

        level: Annotated[str, Data("int")] = "high"

    with pytest.raises(ValueError, match="level: 'high' is not of type int"):
        Wrong.profiles()


def test_what_is_said_of_a_value_is_kept_beside_a_derived_code() -> None:
    class Level(Payload):
        """How high."""

        level: Annotated[int, Data(obligation="O", description="how high", note="a guess")] = 0
        bare: int = 0

    assert Level.data()["level"] == Data("int", "O", "how high", "XML", "a guess")
    assert Level.data()["bare"] == Data("int", source="OpenRoIS")


def test_payloads_are_frozen_and_closed() -> None:
    told = ReachedTarget(target="lobby", is_final_target=True)
    with pytest.raises(ValueError, match="frozen"):
        told.target = "door"  # type: ignore[misc]
    with pytest.raises(ValueError, match="Extra inputs"):
        ReachedTarget(target="lobby", is_final_target=True, mood="good")  # type: ignore[call-arg]
