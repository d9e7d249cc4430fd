"""What a remote engine gives, against the profile that promised it."""

import pytest

from openrois.remote.remote_profile import Kind, first_misfit, promise_of
from openrois.types.messages import Result
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
)

PROMISED = tuple(
    ParameterProfile(name=name, data_type_ref=RoISIdentifier(code=code))
    for name, code in (("level", "int"), ("note", "string"))
)
MESSAGES: tuple[tuple[Kind, str], ...] = (
    ("command", "switch"),
    ("query", "look"),
    ("event", "switched"),
    ("parameters", "get_parameter"),
)
PROFILE = HRIComponentProfile(
    identifier=RoISIdentifier(code="urn"),
    name="lamp",
    command_profiles=(CommandMessageProfile(name="switch", results=PROMISED),),
    query_profiles=(QueryMessageProfile(name="look", results=PROMISED),),
    event_profiles=(EventMessageProfile(name="switched", results=PROMISED), EventMessageProfile(name="look")),
    parameter_profiles=PROMISED,
)


def result(name: str, value: str) -> Result:
    return Result(name=name, data_type_ref="whatever", value=value)


def misfit(kind: Kind, message: str, results: tuple[Result, ...]) -> str | None:
    return first_misfit(promise_of(PROFILE, kind, message), results)


@pytest.mark.parametrize(
    "results", [(), (result("level", "5"),), (result("note", "x"), result("level", "-1"), result("note", ""))]
)
def test_what_fits(results: tuple[Result, ...]) -> None:
    for kind, message in MESSAGES:
        assert misfit(kind, message, results) is None


@pytest.mark.parametrize(
    ("results", "words"),
    [
        ((result("level", "much"),), "level: 'much' is not of type int"),
        ((result("note", "x"), result("shape", "round")), "'shape'"),
    ],
)
def test_what_does_not(results: tuple[Result, ...], words: str) -> None:
    for kind, message in MESSAGES:
        assert words in (misfit(kind, message, results) or "")


def test_a_message_that_was_never_promised() -> None:
    assert misfit("command", "explode", ()) is None
    assert misfit("command", "explode", (result("level", "5"),)) is not None


def test_messages_of_one_name_and_two_kinds() -> None:
    assert misfit("query", "look", (result("level", "5"),)) is None
    assert misfit("event", "look", (result("level", "5"),)) is not None
