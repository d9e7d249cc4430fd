"""What is kept, and what is forgotten first."""

from openrois.remembered import Remembered
from openrois.types.messages import Result


def text(length: int) -> tuple[Result, ...]:
    return (Result(name="text", data_type_ref="string", value="x" * length),)


def test_entries_are_bounded() -> None:
    kept: Remembered[int] = Remembered(2)
    for number, key in enumerate("abc"):
        kept.put(key, number, ())
    assert [key in kept for key in "abc"] == [False, True, True]
    assert [kept.get(key) for key in "abc"] == [None, 1, 2]
    assert list(kept.newest_first()) == [2, 1]


def test_text_is_bounded() -> None:
    kept: Remembered[str] = Remembered(10, most_text=100)
    for key in "abc":
        kept.put(key, key, text(40))
    assert list(kept.newest_first()) == ["c", "b"]
    kept.put("d", "d", text(1) * 61)
    assert list(kept.newest_first()) == ["d"]
    kept.put("long", "long", text(101))
    assert list(kept.newest_first()) == []
    kept.put("a", "a", text(100))
    assert list(kept.newest_first()) == ["a"]


def test_an_entry_that_is_replaced_weighs_once() -> None:
    kept: Remembered[int] = Remembered(10, most_text=100)
    kept.put("other", 0, text(20))
    for number in range(5):
        kept.put("a", number, text(80))
    assert list(kept.newest_first()) == [4, 0]
