"""Command ids of one application."""

import pytest

from openrois.command_log import CommandLog
from openrois.errors import BadParameter, OutOfResources
from openrois.types.messages import Result

TOTAL = (Result(name="total", data_type_ref="int", value="1"),)


def test_a_command_runs_then_has_results() -> None:
    log = CommandLog()
    log.accept(["a", "b"])
    assert "a" in log
    assert log.results("a") == ()
    log.finish("a", TOTAL)
    assert "a" in log
    assert log.results("a") == TOTAL
    assert log.results("b") == ()


def test_an_unknown_command_has_none() -> None:
    log = CommandLog()
    assert "x" not in log
    with pytest.raises(BadParameter):
        log.results("x")


def test_finished_commands_are_forgotten_oldest_first_and_running_ones_never() -> None:
    log = CommandLog(max_finished=2)
    log.accept(["a", "b", "c", "running"])
    for command_id in "abc":
        log.finish(command_id, TOTAL)
    assert ["a" in log, "b" in log, "c" in log, "running" in log] == [False, True, True, True]


def test_commands_that_run_are_bounded_all_or_none() -> None:
    log = CommandLog(max_running=2)
    log.accept(["a"])
    with pytest.raises(OutOfResources):
        log.accept(["b", "c"])
    assert "b" not in log
    log.finish("a", ())
    log.accept(["b", "c"])
