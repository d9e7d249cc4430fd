"""A queue that takes memory only while something is in it."""

import sys

import pytest

from openrois.aio.lean_queue import LeanQueue


def test_a_queue_returns_what_came_first() -> None:
    queue = LeanQueue("ab")
    queue.put("c")
    assert (list(queue), len(queue), queue.first()) == (["a", "b", "c"], 3, "a")
    assert [queue.pop() for _ in range(3)] == ["a", "b", "c"]
    assert (list(queue), len(queue), queue.first()) == ([], 0, None)
    with pytest.raises(IndexError, match="empty queue"):
        queue.pop()


def test_a_queue_that_was_cleared_is_empty_and_goes_on() -> None:
    queue = LeanQueue([1, 2])
    queue.clear()
    queue.put(3)
    assert list(queue) == [3]


def test_an_empty_queue_takes_little_also_behind_a_burst() -> None:
    queue = LeanQueue[int]()
    for number in range(1000):
        queue.put(number)
    while queue:
        queue.pop()
    assert sys.getsizeof(queue) < 64
    assert queue._items is None
