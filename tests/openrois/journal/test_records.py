"""What a journal writes down: texts that a database can hold, and results up to a bound."""

import pytest

from openrois.journal.records import MAX_RESULTS, read_results, storable, written_results
from openrois.types.messages import Result

pytestmark = pytest.mark.extra(name="base")


def given(value: str) -> tuple[Result, ...]:
    return (Result(name="total", data_type_ref="integer", value=value),)


@pytest.mark.parametrize(("text", "stored"), [("ü 1", "ü 1"), ("\ud800", r"\ud800"), ("a\0b", r"a\x00b")])
def test_a_text_is_stored_as_it_is_or_as_an_escape(text: str, stored: str) -> None:
    assert storable(text) == stored


@pytest.mark.parametrize("results", [(), given("3"), given("\0 ü")])
def test_results_are_read_as_they_were_written(results: tuple[Result, ...]) -> None:
    assert read_results(written_results(results)) == results


def test_results_are_kept_up_to_a_bound() -> None:
    text = written_results(given(""))
    assert text is not None
    room = MAX_RESULTS - len(text)
    assert written_results(given("x" * room)) is not None
    assert written_results(given("x" * (room + 1))) is None


@pytest.mark.parametrize("text", [None, "", "{}", '[{"name": 7}]'])
def test_what_was_not_kept_or_is_damaged_is_none(text: str | None) -> None:
    assert read_results(text) is None
