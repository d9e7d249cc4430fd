"""The components of each body, as its engine has them; no game engine and no robot is needed for that."""

import re
import tempfile
import tomllib
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Self, cast

from openrois_avatar.adapter import serve_scene
from openrois_avatar.scene import external_scene
from openrois_robots.kachaka.adapter import hosted_kachaka, linked_kachaka
from openrois_robots.kachaka.api.address import Address
from openrois_robots.kachaka.options import KachakaSettings
from openrois_robots.reachy.adapter import hosted_reachy, linked_reachy
from openrois_robots.reachy.daemon.address import Address as DaemonAddress
from openrois_robots.reachy.options import ReachySettings
from openrois_robots.ros2 import adapter as ros2
from openrois_robots.ros2.graph.backend import RosBackend
from openrois_robots.ros2.mapping.reading import read_mapping
from openrois_robots.simulated import adapter as simulated
from openrois_robots.simulated.simulation import SimulationSettings
from openrois_streaming.clock import SystemClock

from openrois.types.profiles import HRIComponentProfile

__all__ = ["BODIES", "Profiles"]

Profiles = Mapping[str, HRIComponentProfile]
"""The profiles of a body's components, by their refs."""

_PAGE_OF_ROS: Final = Path(__file__).parents[2] / "docs/how-to/ros2.md"

_CLOCK: Final = SystemClock()


@asynccontextmanager
async def _avatar() -> AsyncIterator[Profiles]:
    # A figure is in the scene of every game engine, also before one has connected.
    with tempfile.TemporaryDirectory() as folder:
        async with (
            external_scene("avatar", f"unix:{folder}/engine", "", _CLOCK) as scene,
            serve_scene("avatar", scene, _CLOCK) as served,
        ):
            yield served.host.engine.directory.component_profiles


@asynccontextmanager
async def _simulated() -> AsyncIterator[Profiles]:
    async with (
        simulated.simulated_robot("robot", SimulationSettings(), _CLOCK) as robot,
        simulated.hosted_robot("robot", robot, _CLOCK) as served,
    ):
        yield served.host.engine.directory.component_profiles


@asynccontextmanager
async def _kachaka() -> AsyncIterator[Profiles]:
    # A component is in the profile also before its robot was reached.
    async with (
        linked_kachaka("kachaka", KachakaSettings(Address("127.0.0.1", 1)), _CLOCK) as linked,
        hosted_kachaka("kachaka", linked, _CLOCK) as served,
    ):
        yield served.host.engine.directory.component_profiles


@asynccontextmanager
async def _reachy() -> AsyncIterator[Profiles]:
    settings = ReachySettings(DaemonAddress("127.0.0.1", 1))
    async with (
        linked_reachy("reachy", settings, _CLOCK) as linked,
        hosted_reachy("reachy", linked, _CLOCK) as served,
    ):
        yield served.host.engine.directory.component_profiles


@asynccontextmanager
async def _ros2() -> AsyncIterator[Profiles]:
    mapping = read_mapping(tomllib.loads(_mapping_file()))
    async with (
        ros2.ros_robot("robot", mapping, cast("RosBackend", _NoGraph()), _CLOCK, "the robot") as robot,
        ros2.hosted_robot("robot", robot, _CLOCK) as served,
    ):
        yield served.host.engine.directory.component_profiles


def _mapping_file() -> str:
    """Return the mapping file of the page about ROS 2, which names all that can be mapped."""
    found = re.search(r"```toml\n(.*?)```", _PAGE_OF_ROS.read_text(encoding="utf-8"), re.DOTALL)
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


BODIES: Final[Mapping[str, Callable[[], AbstractAsyncContextManager[Profiles]]]] = MappingProxyType(
    {"avatar": _avatar, "simulated robot": _simulated, "Kachaka": _kachaka, "Reachy Mini": _reachy, "ROS 2": _ros2}
)
"""By the name of a body: its profiles, for as long as the block runs."""
