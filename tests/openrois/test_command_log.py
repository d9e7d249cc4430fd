"""Command ids of one application."""

import pytest

from openrois.command_log import RECENT, CommandLog
from openrois.errors import BadParameter, OutOfResources
from openrois.types.messages import Result
from tests.support.clock import Clock

TOTAL = (Result(name="total", data_type_ref="int", value="1"),)


def on(component_ref: str, *command_ids: str) -> dict[str, str]:
    return dict.fromkeys(command_ids, component_ref)


def test_a_command_runs_then_has_results() -> None:
    log = CommandLog(Clock())
    log.accept(on("lamp", "a", "b"))
    assert "a" in log
    assert log.results("a") == ()
    log.finish("a", TOTAL)
    assert "a" in log
    assert log.results("a") == TOTAL
    assert log.results("b") == ()


def test_an_unknown_command_has_none() -> None:
    log = CommandLog(Clock())
    assert "x" not in log
    with pytest.raises(BadParameter):
        log.results("x")


def test_finished_commands_are_forgotten_oldest_first_and_running_ones_never() -> None:
    log = CommandLog(Clock(), max_finished=2)
    log.accept(on("lamp", "a", "b", "c", "running"))
    for command_id in "abc":
        log.finish(command_id, TOTAL)
    assert ["a" in log, "b" in log, "c" in log, "running" in log] == [False, True, True, True]


def test_commands_that_run_are_bounded_all_or_none() -> None:
    log = CommandLog(Clock(), max_running=2)
    log.accept(on("lamp", "a"))
    with pytest.raises(OutOfResources):
        log.accept(on("lamp", "b", "c"))
    assert "b" not in log
    log.finish("a", ())
    log.accept(on("lamp", "b", "c"))


def test_a_command_is_on_its_component_until_a_moment_after_its_end() -> None:
    clock = Clock()
    log = CommandLog(clock)
    log.accept(on("lamp", "a") | on("bell", "b"))
    log.finish("a", ())
    clock.now += RECENT
    log.accept(on("door", "c"))
    log.finish("c", ())
    assert [log.has_one_on(ref) for ref in ("lamp", "bell", "door", "window")] == [True, True, True, False]
    clock.now += 0.1
    assert [log.has_one_on(ref) for ref in ("lamp", "bell", "door")] == [False, True, True]
    clock.now += RECENT
    assert [log.has_one_on(ref) for ref in ("lamp", "bell", "door")] == [False, True, False]
