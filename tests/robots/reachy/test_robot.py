"""What the daemon tells of itself, read."""

from typing import Any

import pytest
from openrois_robots.reachy.robot import _not_running, _sound_problem

pytestmark = pytest.mark.extra(name="reachy")


@pytest.mark.parametrize(
    ("status", "problem"),
    [
        ({"state": "running", "backend_status": {"error": None}}, ""),
        ({"state": "running", "backend_status": {"ready": True}}, ""),
        ({"state": "running", "backend_status": {"ready": False}}, "is not ready yet"),
        ({"state": "running", "backend_status": {"error": "a motor is hot"}}, "does not work: a motor is hot"),
        ({"state": "stopped", "backend_status": None}, "does not run: its daemon is in the state 'stopped'"),
        ({"state": "error", "error": "no port"}, "does not run: its daemon is in the state 'error': no port"),
        ({}, "does not run: its daemon is in the state 'None'"),
    ],
)
def test_a_daemon_that_does_not_run_says_why(status: dict[str, Any], problem: str) -> None:
    assert _not_running(status) == problem


@pytest.mark.parametrize(
    ("media", "problem"),
    [
        ({"available": True, "released": False, "no_media": False}, ""),
        ({"available": False, "released": False, "no_media": True}, "runs without media"),
        ({"available": False, "released": True, "no_media": False}, "another program has the robot's loudspeaker"),
        ({"available": False, "released": False, "no_media": False}, "has no media server"),
    ],
)
def test_a_robot_without_sound_says_why(media: dict[str, Any], problem: str) -> None:
    assert problem in _sound_problem(media)
    assert bool(_sound_problem(media)) is bool(problem)
