"""What each body can do, as its own profile says: a row for each type of component, a column for each body."""

import asyncio
from contextlib import AsyncExitStack
from typing import Final

from openrois.catalog.basic import BASIC_COMPONENTS
from tools.pages.body_profiles import BODIES, Profiles

__all__ = ["bodies"]


def bodies() -> list[str]:
    """Return two tables: the standard's components, and those of OpenRoIS."""
    profiles = asyncio.run(_profiles())
    codes = {each.identifier.code: None for own in profiles.values() for each in own.values()}
    standard: Final = [kind.code for kind in BASIC_COMPONENTS]
    return [
        *_table("of the standard", standard, profiles),
        "",
        *_table("of OpenRoIS", sorted(set(codes) - set(standard)), profiles),
    ]


def _table(title: str, codes: list[str], profiles: dict[str, Profiles]) -> list[str]:
    rows = [[code, *(_cell(code, own) for own in profiles.values())] for code in codes]
    head = [title, *profiles]
    return [f"| {' | '.join(cells)} |" for cells in (head, ["-"] * len(head), *rows)]


def _cell(code: str, own: Profiles) -> str:
    """Return the names of a body's components of a type."""
    names = sorted(ref.partition("/")[2] for ref, each in own.items() if each.identifier.code == code)
    return ", ".join(f"`{name}`" for name in names)


async def _profiles() -> dict[str, Profiles]:
    async with AsyncExitStack() as stack:
        return {name: dict(await stack.enter_async_context(body())) for name, body in BODIES.items()}
