"""Command ids of one application, and the commands of all."""

import pytest

from openrois.commands.history import MAX_FINISHED, MAX_RUNNING, RECENT, CommandHistory
from openrois.commands.quota import CommandQuota
from openrois.errors import BadParameter, OutOfResources
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result
from tests.support.clock import Clock

TOTAL = (Result(name="total", data_type_ref="int", value="1"),)


def on(component_ref: str, *command_ids: str) -> dict[str, str]:
    return dict.fromkeys(command_ids, component_ref)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def log(clock: Clock) -> CommandHistory:
    return CommandHistory(clock, CommandQuota())


def test_a_command_runs_then_has_results(log: CommandHistory) -> None:
    log.accept(on("lamp", "a", "b"))
    assert "a" in log
    assert log.results("a") == ()
    log.finish("a", TOTAL)
    assert "a" in log
    assert log.results("a") == TOTAL
    assert log.results("b") == ()


def test_how_many_are_unfinished_and_how_one_ended(clock: Clock) -> None:
    budget = CommandQuota(3)
    log = CommandHistory(clock, budget)
    log.accept(on("lamp", "a", "b"))
    log.finish("a", TOTAL, CompletedStatus.ABORT, "it was stopped")
    assert (log.unfinished, budget.taken) == (1, 1)
    assert log.ending("a") == (CompletedStatus.ABORT, "it was stopped")
    assert log.ending("b") is None


def test_an_unknown_command_has_none(log: CommandHistory) -> None:
    assert "x" not in log
    with pytest.raises(BadParameter):
        log.results("x")


def test_finished_commands_are_forgotten_oldest_first_and_running_ones_never(log: CommandHistory) -> None:
    log.accept(on("lamp", "running"))
    for number in range(MAX_FINISHED + 1):
        log.accept(on("lamp", str(number)))
        log.finish(str(number), TOTAL)
    assert ["0" in log, "1" in log, "running" in log] == [False, True, True]


def test_commands_that_run_are_bounded_all_or_none(log: CommandHistory) -> None:
    log.accept(on("lamp", *(str(number) for number in range(MAX_RUNNING - 1))))
    with pytest.raises(OutOfResources):
        log.accept(on("lamp", "b", "c"))
    assert "b" not in log
    log.finish("0", ())
    log.accept(on("lamp", "b", "c"))


def test_the_commands_of_all_applications_are_bounded_all_or_none(clock: Clock) -> None:
    budget = CommandQuota(most=3)
    one, other = CommandHistory(clock, budget), CommandHistory(clock, budget)
    one.accept(on("lamp", "a", "b"))
    with pytest.raises(OutOfResources):
        other.accept(on("lamp", "a", "b"))
    assert "a" not in other
    other.accept(on("lamp", "a"))
    with pytest.raises(OutOfResources):
        one.accept(on("lamp", "c"))
    one.finish("a", ())
    one.accept(on("lamp", "c"))


def test_what_is_kept_of_commands_is_bounded_and_given_back_with_the_last_of_them(clock: Clock) -> None:
    budget = CommandQuota()
    log = CommandHistory(clock, budget, most_text=10)
    log.accept(on("lamp", "a", "b"), text=10)
    for command_id in ("a", "b"):
        with pytest.raises(OutOfResources, match="at most 10 bytes are kept of the unfinished commands of one appl"):
            log.accept(on("lamp", "c"), text=1)
        log.finish(command_id, (), CompletedStatus.ABORT)
    assert (budget.taken, budget.text) == (0, 0)
    log.accept(on("lamp", "c"), text=10)


def test_a_command_is_on_its_component_until_a_moment_after_its_end(log: CommandHistory, clock: Clock) -> None:
    log.accept(on("lamp", "a") | on("bell", "b"))
    log.finish("a", ())
    clock.now += RECENT
    log.accept(on("door", "c"))
    log.finish("c", ())
    assert [ref in set(log.components()) for ref in ("lamp", "bell", "door", "window")] == [True, True, True, False]
    clock.now += 0.1
    assert [ref in set(log.components()) for ref in ("lamp", "bell", "door")] == [False, True, True]
    clock.now += RECENT
    assert [ref in set(log.components()) for ref in ("lamp", "bell", "door")] == [False, True, False]
