"""Listeners to one kind of occurrence, which come and go. Pure."""

from collections.abc import Callable
from functools import partial
from typing import Generic, TypeVarTuple

__all__ = ["Listeners"]

What = TypeVarTuple("What")


class Listeners(Generic[*What]):
    """Functions that are called in the order in which they were added; they must not block and must not raise."""

    def __init__(self) -> None:
        self._listeners: dict[object, Callable[[*What], None]] = {}

    def add(self, listener: Callable[[*What], None]) -> Callable[[], None]:
        """Call `listener` from now on; return a function that removes it, which may be called more than once."""
        key = object()
        self._listeners[key] = listener
        return partial(self._remove, key)

    def _remove(self, key: object) -> None:
        self._listeners.pop(key, None)

    def notify_all(self, *what: *What) -> None:
        """Call every listener that was there when the call began."""
        for listener in tuple(self._listeners.values()):
            listener(*what)
