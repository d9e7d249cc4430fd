"""What each body can do, as its own profile says: a row for each type of component, a column for each body."""

import asyncio
import tempfile
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Final

from openrois_avatar.adapter import serve_scene
from openrois_avatar.scene import external_scene
from openrois_robots.simulated.adapter import hosted_robot, simulated_robot
from openrois_robots.simulated.simulation import SimulationSettings
from openrois_streaming.clock import SystemClock

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.types.profiles import HRIComponentProfile

__all__ = ["bodies"]

Profiles = Mapping[str, HRIComponentProfile]


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

    async with avatar() as of_avatar, robot() as of_robot:
        return {"the avatar": dict(of_avatar), "the simulated robot": dict(of_robot)}
