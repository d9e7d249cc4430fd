"""The simulated robot's base: what velocities, goals and its watchdog do."""

from math import dist, pi

import pytest
from openrois_robots.ros2.simulator.model import EDGE, WATCHDOG, Goal, Model

STEP = 0.02


def run(model: Model, seconds: float, now: float = 0.0, *, renewed: bool = False) -> float:
    """Let time pass; `renewed`: the last velocity comes again and again."""
    for _ in range(round(seconds / STEP)):
        now += STEP
        if renewed:
            model.obey(*model._wanted, now)
        model.step(STEP, now)
    return now


def test_it_goes_while_it_is_told_and_stands_when_it_is_not() -> None:
    model = Model()
    model.obey(0.5, 0.0, 0.0)
    now = run(model, 2.0, renewed=True)
    assert model.speed == pytest.approx(0.5)
    assert model.x == pytest.approx(0.94, abs=0.03)
    run(model, WATCHDOG + 0.4, now)
    assert model.speed == 0


def test_it_is_no_faster_than_it_can_be() -> None:
    model = Model()
    model.obey(9.0, -9.0, 0.0)
    run(model, 2.0, renewed=True)
    assert (model.speed, model.turn) == pytest.approx((0.8, -1.6))


@pytest.mark.parametrize("goal", [(1.0, 1.0, pi / 2), (-2.0, 0.5, 0.0), (0.0, 0.0, pi)])
def test_a_goal_is_reached_in_place_and_direction(goal: tuple[float, float, float]) -> None:
    model, asked = Model(), Goal(*goal)
    model.pursue(asked)
    run(model, 20.0)
    assert model.goal is None
    assert asked.is_there
    assert dist((model.x, model.y), goal[:2]) < 0.1
    assert abs(model.th) == pytest.approx(abs(goal[2]), abs=0.1)


def test_a_goal_is_driven_within_the_limit() -> None:
    model = Model(limit=0.2)
    model.pursue(Goal(2.0, 0.0, 0.0))
    now, fastest = 0.0, 0.0
    for _ in range(200):
        now += STEP
        model.step(STEP, now)
        fastest = max(fastest, model.speed)
    assert fastest == pytest.approx(0.2)


def test_a_velocity_ends_a_goal_and_a_zero_does_not() -> None:
    model = Model()
    model.pursue(Goal(2.0, 0.0, 0.0))
    model.obey(0.0, 0.0, 0.0)
    assert model.goal is not None
    model.obey(0.1, 0.0, 0.0)
    assert model.goal is None


def test_it_stays_on_its_floor_and_its_battery_runs_down() -> None:
    model = Model(percent=0.1)
    model.obey(0.8, 0.0, 0.0)
    run(model, 20.0, renewed=True)
    assert model.x == EDGE
    assert model.percent < 0.1
    run(model, 300.0, renewed=True)
    assert model.percent == 0
