"""What is kept, and what is forgotten first."""

from openrois.aio.bounded_history import RESULT_OVERHEAD, BoundedHistory
from openrois.types.messages import Result


def text(length: int) -> tuple[Result, ...]:
    """Return a result that weighs as much, beside a key of one character."""
    rest = length - RESULT_OVERHEAD - len("text") - len("string") - len("k")
    return (Result(name="text", data_type_ref="string", value="x" * rest),)


def test_entries_are_bounded() -> None:
    kept: BoundedHistory[int] = BoundedHistory(2)
    for number, key in enumerate("abc"):
        kept.put(key, number, ())
    assert [key in kept for key in "abc"] == [False, True, True]
    assert [kept.get(key) for key in "abc"] == [None, 1, 2]
    assert list(kept.newest_first()) == [2, 1]


def test_the_oldest_are_dropped_while_they_are_over() -> None:
    kept: BoundedHistory[int] = BoundedHistory(10, most_text=1120)
    for number, key in enumerate("abcd"):
        kept.put(key, number % 3, text(280))
    kept.drop_oldest(lambda entry: entry < 2)
    assert (list(kept.newest_first()), len(kept)) == ([0, 2], 2)
    # Their room is free again.
    kept.put("e", 1, text(440))
    assert list(kept.newest_first()) == [1, 0, 2]
    kept.drop_oldest(lambda _entry: True)
    assert len(kept) == 0


def test_text_is_bounded() -> None:
    kept: BoundedHistory[str] = BoundedHistory(10, most_text=1000)
    for key in "abc":
        kept.put(key, key, text(400))
    assert list(kept.newest_first()) == ["c", "b"]
    kept.put("d", "d", text(601))
    assert list(kept.newest_first()) == ["d"]
    kept.put("e", "e", text(1001))
    assert list(kept.newest_first()) == []
    kept.put("f", "f", text(1000))
    assert list(kept.newest_first()) == ["f"]


def test_whatever_takes_room_counts() -> None:
    tiny = Result(name="", data_type_ref="", value="")
    for key, results in (
        ("k" * 1001, ()),
        ("k", (Result(name="n" * 1000, data_type_ref="", value=""),)),
        ("k", (Result(name="", data_type_ref="t" * 1000, value=""),)),
        ("k", (tiny,) * (1000 // RESULT_OVERHEAD + 1)),
    ):
        kept: BoundedHistory[str] = BoundedHistory(10, most_text=1000)
        kept.put(key, "entry", results)
        assert key not in kept


def test_an_entry_that_is_replaced_weighs_once() -> None:
    kept: BoundedHistory[int] = BoundedHistory(10, most_text=1120)
    kept.put("b", 0, text(300))
    for number in range(5):
        kept.put("a", number, text(700))
    assert list(kept.newest_first()) == [4, 0]
