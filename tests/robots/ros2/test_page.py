"""The page about robots that speak ROS 2 says what the code does."""

import dataclasses
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from openrois_robots.ros2.mapping import settings
from openrois_robots.ros2.mapping.reading import read_mapping
from openrois_robots.ros2.robot import poses, strokes, wheels

pytestmark = pytest.mark.extra(name="ros2")

PAGE = (Path(__file__).parents[3] / "docs/how-to/ros2.md").read_text(encoding="utf-8")
TABLES: dict[str, Any] = {
    "ros": settings.Ros,
    "base": settings.DrivingLimits,
    "odometry": settings.Odometry,
    "pose": settings.Pose,
    "battery": settings.Battery,
    "velocity": settings.Velocity,
    "navigation": settings.Navigation,
    "follow": settings.Follow,
    "camera.video_streaming": settings.Camera,
    "speech": settings.Speech,
}
NAMED = {"topic", "action", "targets", "dock"}
"""What a file has to say by itself."""


def example() -> dict[str, Any]:
    """Return the mapping file of the page."""
    found = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return tomllib.loads(found[1])


def test_the_example_is_a_mapping_file() -> None:
    mapping = read_mapping(example())
    assert mapping.places.keys() == {"dock", "table"}
    assert all((mapping.odometry, mapping.pose, mapping.battery, mapping.velocity, mapping.navigation))
    assert all((mapping.follow, mapping.cameras, mapping.speech))


@pytest.mark.parametrize("name", TABLES)
def test_it_has_every_key_with_its_default(name: str) -> None:
    table: Any = example()
    for part in name.split("."):
        table = table[part]
    fields = {each.name: each.default for each in dataclasses.fields(TABLES[name])}
    assert table.keys() == fields.keys()
    assert {key: value for key, value in table.items() if key not in NAMED} == {
        key: value for key, value in fields.items() if key not in NAMED
    }


@pytest.mark.parametrize(
    "sentence",
    [
        f"A velocity holds for {wheels.HOLD:g} s",
        f"ends where {strokes.STUCK:g} s bring no progress",
        f"where the clocks agree to {poses.OLDEST:g} s",
        "UNINITIALIZED: /odom is published best_effort, and the mapping file has reliable: set reliability",
    ],
)
def test_it_has_the_figures_of_the_code(sentence: str) -> None:
    assert sentence in " ".join(PAGE.split())
