"""Arguments of the wire against a profile."""

import pytest

from openrois.component.authoring.parameters import check_arguments
from openrois.errors import BadParameter
from openrois.types.messages import Argument
from openrois.types.profiles import ParameterProfile, RoISIdentifier

PROFILES = tuple(
    ParameterProfile(name=name, data_type_ref=RoISIdentifier(code=code))
    for name, code in (("times", "int"), ("note", "string"))
)


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="ignored", value=value)


def test_values_by_name() -> None:
    given = (argument("note", "x"), argument("times", "3"))
    assert check_arguments(PROFILES, given) == {"note": "x", "times": "3"}
    assert check_arguments(PROFILES, ()) == {}


@pytest.mark.parametrize(
    "arguments",
    [
        (argument("colour", "x"),),
        (argument("times", "many"),),
        (argument("times", "1"), argument("times", "1")),
    ],
)
def test_what_does_not_fit(arguments: tuple[Argument, ...]) -> None:
    with pytest.raises(BadParameter):
        check_arguments(PROFILES, arguments)


def test_a_message_without_arguments_says_so() -> None:
    with pytest.raises(BadParameter, match="none"):
        check_arguments((), (argument("x", "y"),))
