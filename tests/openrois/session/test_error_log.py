"""The errors of one application."""

import pytest

from openrois.contract import Fault
from openrois.errors import BadParameter
from openrois.session.error_log import MAX_ERRORS, ErrorLog
from openrois.types.codes import ErrorType


def fault(error_id: str) -> Fault:
    return Fault(error_id, ErrorType.USER_DEFINED_ERROR, "robot/lamp", "dim", "now")


def test_what_was_told_can_be_asked() -> None:
    log = ErrorLog()
    log.note(fault("a"))
    assert {result.name: result.value for result in log.details("a")} == {
        "component_ref": "robot/lamp",
        "error_type": "USER_DEFINED_ERROR",
        "description": "dim",
        "timestamp": "now",
    }
    with pytest.raises(BadParameter):
        log.details("b")


def test_the_oldest_is_forgotten() -> None:
    log = ErrorLog()
    for number in range(MAX_ERRORS + 1):
        log.note(fault(str(number)))
    with pytest.raises(BadParameter):
        log.details("0")
    assert log.details("1")
