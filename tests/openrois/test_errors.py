"""Failures and their codes."""

import pytest

from openrois import errors
from openrois.errors import ComponentFailed, RoISError, error_for, require_usable
from openrois.types.codes import CompletedStatus, ComponentStatus, ReturnCode


@pytest.mark.parametrize("code", [code for code in ReturnCode if code is not ReturnCode.OK])
def test_every_failure_has_an_error_that_carries_it(code: ReturnCode) -> None:
    error = error_for(code, "why")
    assert (error.return_code, str(error)) == (code, "why")


@pytest.mark.parametrize(
    ("name", "code", "status"),
    [
        ("BadParameter", "BAD_PARAMETER", "ERROR"),
        ("Unsupported", "UNSUPPORTED", "ERROR"),
        ("OutOfResources", "OUT_OF_RESOURCES", "OUT_OF_RESOURCES"),
        ("TimedOut", "TIMEOUT", "TIMEOUT"),
        ("ComponentFailed", "ERROR", "ERROR"),
        ("EngineUnreachable", "ERROR", "ERROR"),
        ("Aborted", "ERROR", "ABORT"),
    ],
)
def test_codes_of_operations_and_commands(name: str, code: str, status: str) -> None:
    error: type[RoISError] = getattr(errors, name)
    assert (error.return_code, error.completed_status) == (ReturnCode(code), CompletedStatus(status))


@pytest.mark.parametrize("status", [ComponentStatus.READY, ComponentStatus.BUSY])
def test_a_component_that_can_be_used(status: ComponentStatus) -> None:
    require_usable("arm", status)


@pytest.mark.parametrize(
    ("status", "sentence"),
    [
        (ComponentStatus.UNINITIALIZED, r"^arm is not connected yet \(UNINITIALIZED\)$"),
        (ComponentStatus.ERROR, r"^arm does not work now \(ERROR\)$"),
        (ComponentStatus.WARNING, r"^arm does not work now \(WARNING\)$"),
    ],
)
def test_a_component_that_cannot_be_used_says_what_that_means(status: ComponentStatus, sentence: str) -> None:
    with pytest.raises(ComponentFailed, match=sentence):
        require_usable("arm", status)


def test_a_component_that_cannot_be_used_says_why_where_that_is_known() -> None:
    with pytest.raises(ComponentFailed, match=r"^arm does not work now \(ERROR\): its motors are off$"):
        require_usable("arm", ComponentStatus.ERROR, "its motors are off")
