"""What each body can do, as its own profile says: a row for each type of component, a column for each body."""

import asyncio
import re
import tempfile
import tomllib
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final, Self, cast

from openrois_avatar.adapter import serve_scene
from openrois_avatar.scene import external_scene
from openrois_robots.ros2.adapter import hosted_robot as hosted_robot_of_ros
from openrois_robots.ros2.adapter import ros_robot
from openrois_robots.ros2.graph.backend import RosBackend
from openrois_robots.ros2.mapping.reading import read_mapping
from openrois_robots.simulated.adapter import hosted_robot, simulated_robot
from openrois_robots.simulated.simulation import SimulationSettings
from openrois_streaming.clock import SystemClock

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.types.profiles import HRIComponentProfile

__all__ = ["bodies"]

Profiles = Mapping[str, HRIComponentProfile]

_PAGE: Final = Path(__file__).parents[2] / "docs/how-to/ros2.md"


def bodies() -> list[str]:
    """Return two tables: the standard's components, and those of OpenRoIS."""
    profiles = asyncio.run(_profiles())
    codes = {each.identifier.code: None for own in profiles.values() for each in own.values()}
    standard = [kind.code for kind in BASIC_COMPONENTS]
    return [
        *_table("of the standard", standard, profiles),
        "",
        *_table("of OpenRoIS", sorted(set(codes) - set(standard)), profiles),
    ]


def _table(title: str, codes: list[str], profiles: Mapping[str, Profiles]) -> list[str]:
    rows = [[code, *(_cell(code, own) for own in profiles.values())] for code in codes]
    head = [title, *profiles]
    return [f"| {' | '.join(cells)} |" for cells in (head, ["-"] * len(head), *rows)]


def _cell(code: str, own: Profiles) -> str:
    """Return the names of a body's components of a type."""
    return ", ".join(f"`{ref}`" for ref, each in sorted(own.items()) if each.identifier.code == code)


async def _profiles() -> dict[str, Profiles]:
    """Return the profiles of the components of each body, as its engine has them."""
    clock: Final = SystemClock()

    @asynccontextmanager
    async def avatar() -> AsyncIterator[Profiles]:
        # A figure is in the scene of every game engine, also before one has connected.
        with tempfile.TemporaryDirectory() as folder:
            async with (
                external_scene("avatar", f"unix:{folder}/engine", "", clock) as scene,
                serve_scene("avatar", scene, clock) as served,
            ):
                yield served.host.engine.directory.component_profiles

    @asynccontextmanager
    async def robot() -> AsyncIterator[Profiles]:
        async with (
            simulated_robot("robot", SimulationSettings(), clock) as simulated,
            hosted_robot("robot", simulated, clock) as served,
        ):
            yield served.host.engine.directory.component_profiles

    @asynccontextmanager
    async def ros() -> AsyncIterator[Profiles]:
        mapping = read_mapping(tomllib.loads(_mapping_file()))
        async with (
            ros_robot("robot", mapping, cast("RosBackend", _NoGraph()), clock, "the robot") as robot,
            hosted_robot_of_ros("robot", robot, clock) as served,
        ):
            yield served.host.engine.directory.component_profiles

    async with avatar() as of_avatar, robot() as of_robot, ros() as of_ros:
        return {"the avatar": dict(of_avatar), "the simulated robot": dict(of_robot), "ROS 2": dict(of_ros)}


def _mapping_file() -> str:
    """Return the mapping file of the page about ROS 2, which names all that can be mapped."""
    found = re.search(r"```toml\n(.*?)```", _PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return found[1]


class _Nothing:
    """An end of a graph that has no other node."""

    name, is_matched, problem = "", False, "there is no robot"

    def close(self) -> None: ...

    def publish(self, message: object) -> None: ...


class _NoGraph:
    """A graph without a robot: profiles follow from the mapping file alone."""

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *error: object) -> None: ...

    def __getattr__(self, _make: str) -> Any:
        return lambda *_what: _Nothing()
