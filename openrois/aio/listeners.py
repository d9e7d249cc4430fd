"""Those who want to hear of something, and leave again."""

from collections.abc import Callable
from typing import Generic, TypeVarTuple

__all__ = ["Listeners"]

What = TypeVarTuple("What")


class Listeners(Generic[*What]):
    """Functions that are called, in the order in which they came; they must not block and must not raise."""

    def __init__(self) -> None:
        self._listeners: dict[object, Callable[[*What], None]] = {}

    def add(self, listener: Callable[[*What], None]) -> Callable[[], None]:
        """Call `listener` from now on; return what ends that, however often it is called."""
        key = object()
        self._listeners[key] = listener

        def leave() -> None:
            self._listeners.pop(key, None)

        return leave

    def tell(self, *what: *What) -> None:
        """Call everybody who listened when this began."""
        for listener in tuple(self._listeners.values()):
            listener(*what)
