"""The parts of a body: components that one session holds at a time, and that change hands together. Pure."""

from collections.abc import Collection
from typing import Final, Protocol

__all__ = ["PART_MARK", "LoneComponents", "Parts", "name_of"]

PART_MARK: Final = "//"
"""Stands between the id of an engine and the name of a part; a reference has one slash."""


class Parts(Protocol):
    """Which components belong together. A component that belongs to no part is one by itself."""

    def part_of(self, component_ref: str) -> str:
        """Return the name of the part of a component: the same text for all of its components, and for no others."""
        ...

    def members(self, part: str, holder: object) -> Collection[str]:
        """Return the components of a part that `holder` can hold."""
        ...


class LoneComponents:
    """Components that belong to no part."""

    def part_of(self, component_ref: str) -> str:
        """Return the component itself."""
        return component_ref

    def members(self, part: str, holder: object) -> Collection[str]:
        """Return the one component that the part is."""
        return (part,)


def name_of(part: str) -> str:
    """Return the name of a part, or empty text for a component that is one by itself."""
    return part.partition(PART_MARK)[2]
