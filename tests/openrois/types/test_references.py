"""References and ids."""

import pytest

from openrois.types.references import engine_of, flaw_of_name, new_id, reference


@pytest.mark.parametrize(
    ("text", "flaw"),
    [("", "empty"), ("a/b", "slash"), ("/", "slash"), ("x" * 129, "more than 128 characters")]
    + [(text, "cannot be printed") for text in ("a\n", "a\0", "a\x1b[31m", "\ud800", "a\u202eb", "\u2028")],
)
def test_what_cannot_name_an_engine(text: str, flaw: str) -> None:
    assert flaw in flaw_of_name(text)


@pytest.mark.parametrize("text", ["a", "robot_a", "ロボット", "é", "🤖", "x" * 128, " "])
def test_what_can(text: str) -> None:
    assert flaw_of_name(text) == ""


@pytest.mark.parametrize(
    ("ref", "engine"), [("a/lamp", "a"), ("a/b/c", "a"), ("a/", "a"), ("a", ""), ("", ""), ("/a", "")]
)
def test_the_engine_that_leads_a_reference(ref: str, engine: str) -> None:
    assert engine_of(ref) == engine


def test_a_reference_leads_back_to_its_engine() -> None:
    assert engine_of(reference("a", "lamp")) == "a"


def test_ids_are_the_engine_and_128_random_bits() -> None:
    ids = {new_id("a") for _ in range(100)}
    assert len(ids) == 100
    assert all(len(bytes.fromhex(one.removeprefix("a/"))) == 16 for one in ids)
