"""Components whose connection was lost: until they are back they count as failing. Pure."""

from collections.abc import Iterable, Iterator
from typing import Final

__all__ = ["LostComponents"]

MAX_LOST: Final = 4096
"""Components that are kept; of more the one that was lost first is dropped."""


class LostComponents:
    """The references of lost components."""

    def __init__(self, most: int = MAX_LOST) -> None:
        self._most = most
        self._refs: dict[str, None] = {}

    def __contains__(self, component_ref: object) -> bool:
        return component_ref in self._refs

    def __iter__(self) -> Iterator[str]:
        return iter(self._refs)

    def __len__(self) -> int:
        return len(self._refs)

    def lose(self, component_refs: Iterable[str]) -> None:
        """Add components that are gone."""
        for ref in component_refs:
            self._refs.pop(ref, None)
            self._refs[ref] = None
        while len(self._refs) > self._most:
            del self._refs[next(iter(self._refs))]

    def found(self, component_refs: Iterable[str]) -> None:
        """Remove components that are back."""
        for ref in component_refs:
            self._refs.pop(ref, None)
