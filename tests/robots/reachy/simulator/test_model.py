"""The simulated robot, and the tasks of its daemon as they were measured on the vendor's."""

from itertools import pairwise

import pytest
from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL, Posture
from openrois_robots.reachy.simulator.model import GO_TO_SLEEP, WAKE_UP, Leg, SimulatedReachy


def run(robot: SimulatedReachy, begin: float, end: float) -> list[Posture]:
    """Let time pass, and return the postures."""
    seen = []
    for step in range(round(begin * 50), round(end * 50)):
        robot.step(step / 50)
        seen.append(robot.posture)
    return seen


def test_a_target_is_reached_with_the_next_step() -> None:
    robot = SimulatedReachy()
    robot.set_target(Posture(yaw=0.5))
    assert run(robot, 0, 0.02) == [Posture(yaw=0.5)]


def test_a_target_during_a_task_is_ignored_without_a_word() -> None:
    robot = SimulatedReachy()
    robot.begin("a", (Leg(Posture(pitch=0.3), 1.0),), 0.0)
    robot.set_target(Posture(yaw=0.5))
    run(robot, 0, 1.1)
    assert robot.posture == Posture(pitch=0.3)
    assert robot.ignored == 1
    assert [task.id for task in robot.finished] == ["a"]


def test_overlapping_tasks_fight() -> None:
    robot = SimulatedReachy()
    robot.begin("a", (Leg(Posture(yaw=0.5), 1.0),), 0.0)
    run(robot, 0, 0.6)
    robot.begin("b", (Leg(Posture(yaw=-0.5), 1.0),), 0.6)
    seen = run(robot, 0.6, 1.0)
    assert max(abs(one.yaw - other.yaw) for one, other in pairwise(seen)) > 0.1


def test_a_stopped_task_has_finished_and_the_robot_stands_there() -> None:
    robot = SimulatedReachy()
    robot.begin("a", WAKE_UP, 0.0)
    robot.begin("b", WAKE_UP, 0.0)
    run(robot, 0, 0.5)
    robot.stop(0.5)
    assert [task.id for task in robot.finished] == ["a", "b"]
    assert robot.stops == [0.5]
    assert len(set(run(robot, 0.5, 1))) == 1


def test_one_task_can_be_cancelled() -> None:
    robot = SimulatedReachy()
    robot.begin("a", WAKE_UP, 0.0)
    assert robot.cancel("a")
    assert not robot.cancel("a")


def test_it_goes_to_sleep_and_its_motors_are_off_then() -> None:
    robot = SimulatedReachy()
    robot.begin("a", GO_TO_SLEEP, 0.0, ends_asleep=True)
    run(robot, 0, 3.1)
    assert robot.posture == ASLEEP
    robot.set_target(NEUTRAL)
    run(robot, 3.1, 3.2)
    assert (robot.posture, robot.motors) == (ASLEEP, "disabled")


def test_a_robot_that_is_held_follows_nothing() -> None:
    robot = SimulatedReachy(is_held=True)
    robot.set_target(Posture(yaw=0.5))
    assert run(robot, 0, 0.1)[-1] == NEUTRAL


@pytest.mark.parametrize("duration", [0.0, 0.01])
def test_a_leg_without_time_is_a_jump(duration: float) -> None:
    robot = SimulatedReachy()
    robot.begin("a", (Leg(Posture(yaw=0.5), duration),), 0.0)
    run(robot, 0, 0.1)
    assert robot.posture == Posture(yaw=0.5)
