"""What a conversation and a day may use, and the file in which the day's use survives."""

import json
import logging
from datetime import date, timedelta
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_agents.mind.limits import CONVERSATION, DAY, Budget, Limits, Used
from openrois_agents.mind.use_file import UseFile

FIRST = date(2026, 11, 28)
FEW, MANY = Limits(3, 100, 10.0), Limits(5, 1_000, 20.0)


class Days:
    """The date, as a test says it."""

    def __init__(self) -> None:
        self.today = FIRST

    def __call__(self) -> date:
        return self.today


@pytest.mark.parametrize("name", ["turns", "tokens", "sound"])
def test_a_conversation_ends_politely_at_each_limit(name: str) -> None:
    budget = Budget(FEW, MANY, Days())
    assert budget.refusal() == ""
    for _ in range(3):
        budget.count_turn() if name == "turns" else None
        budget.count_tokens(34) if name == "tokens" else None
        budget.count_sound(3.4) if name == "sound" else None
    assert "talked for a long time" in budget.refusal()
    budget.begin_conversation()
    assert budget.refusal() == ""


def test_a_day_ends_politely_and_the_next_one_begins_anew() -> None:
    days = Days()
    budget = Budget(FEW, MANY, days)
    for _ in range(5):
        budget.begin_conversation()
        budget.count_turn()
    budget.begin_conversation()
    assert "come back tomorrow" in budget.refusal()
    days.today += timedelta(1)
    assert budget.refusal() == ""


def test_a_clock_that_is_set_back_begins_no_new_day() -> None:
    days = Days()
    budget = Budget(FEW, MANY, days)
    for _ in range(5):
        budget.count_turn()
    budget.begin_conversation()
    days.today -= timedelta(1)
    assert "come back tomorrow" in budget.refusal()
    days.today = FIRST
    assert "come back tomorrow" in budget.refusal()
    days.today += timedelta(1)
    assert budget.refusal() == ""


def test_tokens_that_are_left_are_those_of_the_conversation_and_of_the_day() -> None:
    days = Days()
    budget = Budget(FEW, Limits(9, 130, 9.0), days)
    budget.count_tokens(60)
    assert budget.tokens_left == 40
    budget.count_tokens(60)
    assert budget.tokens_left == 0
    budget.begin_conversation()
    assert budget.tokens_left == 10
    days.today += timedelta(1)
    assert budget.tokens_left == 100


def test_what_is_usual_lets_a_conversation_begin() -> None:
    assert Budget(CONVERSATION, DAY, Days()).refusal() == ""


def test_the_use_of_a_day_survives_a_restart(tmp_path: Path) -> None:
    file = UseFile(tmp_path / "use.json")
    assert file.read() is None
    budget = Budget(FEW, MANY, Days(), file.read(), file.write)
    for _ in range(5):
        budget.count_turn()
    budget.count_sound(1.5)
    budget.count_tokens(7)
    assert file.read() == Used(FIRST, 5, 7, 1.5)
    again = Budget(FEW, MANY, Days(), UseFile(tmp_path / "use.json").read())
    assert "come back tomorrow" in again.refusal()
    tomorrow = Days()
    tomorrow.today += timedelta(1)
    assert Budget(FEW, MANY, tomorrow, file.read()).refusal() == ""
    assert [each.name for each in tmp_path.iterdir()] == ["use.json"]


@pytest.mark.parametrize(
    "text",
    [
        *(b"", b"{", b"[]", b"\xff", b'{"day": 1}', b'{"day": "2026-11-28"}', b'{"day": "2026-11-28", "turns": true}'),
        b'{"day": "2026-11-28", "turns": -1, "tokens": 1, "sound": 1}',
        b'{"day": "2026-11-28", "turns": 1, "tokens": NaN, "sound": 1}',
        b'{"day": "2026-11-28", "turns": 1, "tokens": 1e300, "sound": 1}',
    ],
)
def test_a_file_that_is_none_counts_from_0_and_is_told(
    text: bytes, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "use.json"
    path.write_bytes(text)
    assert UseFile(path).read() is None
    assert "counted from 0" in caplog.text


@given(st.binary(max_size=200) | st.dictionaries(st.sampled_from(["day", "turns"]), st.integers()).map(json.dumps))
def test_whatever_is_in_the_file_it_is_read(tmp_path_factory: pytest.TempPathFactory, text: bytes | str) -> None:
    path = tmp_path_factory.getbasetemp() / "use.json"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    UseFile(path).read()


def test_a_file_that_cannot_be_written_is_told_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "use.json"
    path.mkdir()
    file = UseFile(path)
    with caplog.at_level(logging.WARNING):
        file.write(Used(FIRST))
        file.write(Used(FIRST))
    assert caplog.text.count("cannot be kept") == 1
    assert file.read() is None
    path.rmdir()
    file.write(Used(FIRST, 1))
    assert file.read() == Used(FIRST, 1)
