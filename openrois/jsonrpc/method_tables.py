"""Tables of methods that all connections share: who owns a connection's part of them is bound when one is called."""

from collections.abc import Awaitable, Callable, Iterator, Mapping
from functools import partial
from typing import Any

from openrois.jsonrpc.handler import Handler

__all__ = ["BoundMethods", "SharedMethod"]

SharedMethod = Callable[[Any, dict[str, Any]], Awaitable[Any]]
"""Answers one method for its owner: owner and params in, the result or a `Reply` out."""


class BoundMethods(Mapping[str, Handler]):
    """The methods of one connection. There are thousands of these: each keeps its owners, and no handlers.

    Args:
        parts: tables, and the owner of each; of one name the first table counts.
    """

    __slots__ = ("_parts",)

    def __init__(self, *parts: tuple[Mapping[str, SharedMethod], Any]) -> None:
        self._parts = parts

    def __getitem__(self, name: str) -> Handler:
        for table, owner in self._parts:
            shared = table.get(name)
            if shared is not None:
                return partial(shared, owner)
        raise KeyError(name)

    def __contains__(self, name: object) -> bool:
        return any(name in table for table, _ in self._parts)

    def __iter__(self) -> Iterator[str]:
        return iter({name: None for table, _ in self._parts for name in table})

    def __len__(self) -> int:
        return len({name for table, _ in self._parts for name in table})

    def before(self, *others: "BoundMethods") -> "BoundMethods":
        """Return these methods and others; of one name the first counts."""
        return BoundMethods(*self._parts, *(part for each in others for part in each._parts))
