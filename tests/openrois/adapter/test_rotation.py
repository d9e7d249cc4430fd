"""Which gateway an adapter dials next: time and chance are the test's."""

from collections import Counter
from collections.abc import Callable
from itertools import cycle
from random import Random

import pytest

from openrois.adapter.rotation import Rotation


def all_of_it() -> float:
    """Return the longest waits that chance allows, and the given order."""
    return 1.0


def attempts(rotation: Rotation, fail: Callable[[str, float], None], count: int) -> list[tuple[str, float]]:
    """Dial so many times, each without success; return which gateway was dialled when."""
    now, made = 0.0, []
    for _ in range(count):
        url, wait = rotation.next(now)
        now += wait
        made.append((url, now))
        fail(url, now)
    return made


def test_a_single_gateway_is_dialled_with_growing_pauses() -> None:
    rotation = Rotation(["a"], all_of_it)
    made = attempts(rotation, lambda _url, now: rotation.failed(now), 6)
    assert made == [("a", 0), ("a", 0.25), ("a", 0.625), ("a", 1.1875), ("a", 2.03125), ("a", 3.03125)]


def test_the_next_is_dialled_at_once_and_there_is_a_pause_after_a_full_round() -> None:
    rotation = Rotation(["a", "b", "c"], all_of_it)
    made = attempts(rotation, lambda _url, now: rotation.failed(now), 7)
    assert made == [("a", 0), ("b", 0), ("c", 0), ("a", 0.25), ("b", 0.25), ("c", 0.25), ("a", 0.625)]


def test_a_connection_that_ends_is_followed_by_another_gateway_at_once() -> None:
    rotation = Rotation(["a", "b"], all_of_it)
    assert rotation.next(0) == ("a", 0)
    rotation.failed(0)
    assert rotation.next(0) == ("b", 0)
    rotation.failed(3600, lasted=3600)
    assert rotation.next(3600) == ("a", 0)
    rotation.failed(3600)
    assert rotation.next(3600) == ("b", 0.25)


def test_a_gateway_that_asks_for_time_delays_no_other() -> None:
    rotation = Rotation(["a", "b"], all_of_it)
    asked = {"a": 8.0, "b": 0.0}
    made = attempts(rotation, lambda url, now: rotation.failed(now, asked=asked[url]), 5)
    assert made == [("a", 0), ("b", 0), ("b", 0.25), ("b", 0.625), ("b", 1.1875)]
    assert rotation.next(8.25) == ("a", 0)


def test_one_that_refuses_is_dialled_more_rarely_than_one_that_is_not_there() -> None:
    rotation = Rotation(["a", "b"], all_of_it)
    made = attempts(rotation, lambda url, now: rotation.failed(now, is_refused=url == "a"), 200)
    often = Counter(url for url, at in made if at > 20)
    assert 4 <= often["b"] / often["a"] <= 6


def test_an_address_that_stands_twice_counts_once() -> None:
    rotation = Rotation(["a", "a"], all_of_it)
    made = attempts(rotation, lambda _url, now: rotation.failed(now), 2)
    assert made == [("a", 0), ("a", 0.25)]


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_fleet_is_spread_at_first_and_when_one_gateway_is_gone(count: int) -> None:
    chance, urls = Random(7), [str(number) for number in range(count)]
    first, second = Counter[str](), Counter[str]()
    for _ in range(1000):
        rotation = Rotation(urls, chance.random)
        url, _wait = rotation.next(0)
        first[url] += 1
        if url == "0":
            rotation.failed(0)
            second[rotation.next(0)[0]] += 1
    assert first.keys() == set(urls)
    assert min(first.values()) > 1000 / count * 0.7
    assert second.keys() == set(urls) - {"0"}
    assert min(second.values()) > first["0"] / (count - 1) * 0.5


def test_chance_makes_pauses_shorter() -> None:
    rotation = Rotation(["a"], cycle([0.5]).__next__)
    made = attempts(rotation, lambda _url, now: rotation.failed(now), 3)
    assert made == [("a", 0), ("a", 0.125), ("a", 0.3125)]
