"""A queue that takes memory only while something is in it: of thousands of connections most have none. Pure."""

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Generic, TypeVar

__all__ = ["LeanQueue"]

Item = TypeVar("Item")


class LeanQueue(Generic[Item]):
    """A queue, first in and first out, which takes 40 bytes while it is empty, where a deque takes 620.

    Args:
        items: that are in it at first.
    """

    __slots__ = ("_items",)

    def __init__(self, items: Iterable[Item] = ()) -> None:
        self._items: deque[Item] | None = deque(items) or None

    def __len__(self) -> int:
        return 0 if self._items is None else len(self._items)

    def __iter__(self) -> Iterator[Item]:
        return iter(self._items or ())

    def first(self) -> Item | None:
        """Return what is taken next; None of an empty queue."""
        return None if self._items is None else self._items[0]

    def put(self, item: Item) -> None:
        """Append something."""
        if self._items is None:
            self._items = deque()
        self._items.append(item)

    def pop(self) -> Item:
        """Take what came first.

        Raises:
            IndexError: the queue is empty.
        """
        if self._items is None:
            raise IndexError("nothing can be taken from an empty queue")
        item = self._items.popleft()
        if not self._items:
            self._items = None
        return item

    def clear(self) -> None:
        """Drop everything."""
        self._items = None
