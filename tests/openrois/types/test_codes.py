"""The enumerations have the standard's members in the standard's order, and stand on the wire by name."""

import json
from enum import StrEnum

import pytest

from openrois.types.codes import (
    CompletedStatus,
    ComponentFunction,
    ComponentStatus,
    ErrorType,
    ReturnCode,
    StreamStatus,
)

MEMBERS: list[tuple[type[StrEnum], str]] = [
    (ReturnCode, "OK ERROR BAD_PARAMETER UNSUPPORTED OUT_OF_RESOURCES TIMEOUT"),
    (CompletedStatus, "OK ERROR ABORT OUT_OF_RESOURCES TIMEOUT"),
    (
        ErrorType,
        "ENGINE_INTERNAL_ERROR COMPONENT_INTERNAL_ERROR COMPONENT_NOT_RESPONDING USER_DEFINED_ERROR",
    ),
    (ComponentStatus, "UNINITIALIZED READY BUSY WARNING ERROR"),
    (
        StreamStatus,
        "STREAMING_NOT_CONNECTED STREAMING_NOT_RUNNING STREAMING_RUNNING STREAMING_SUSPENDED STREAMING_RESUMED",
    ),
    (ComponentFunction, "actuation sensing function"),
]


@pytest.mark.parametrize(("enumeration", "members"), MEMBERS)
def test_members_in_order(enumeration: type[StrEnum], members: str) -> None:
    assert [member.value for member in enumeration] == members.split()


def test_a_member_is_its_name_in_json() -> None:
    assert json.dumps(ReturnCode.BAD_PARAMETER) == '"BAD_PARAMETER"'
