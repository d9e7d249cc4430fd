"""Commands and what is kept of them: of an application, of a subject and of all, given back once."""

import pytest

from openrois.commands.quota import (
    FIRST_OF_SUBJECT,
    FIRST_TEXT_OF_SUBJECT,
    MAX_OF_SUBJECT,
    MAX_TEXT_OF_SUBJECT,
    RESERVED,
    RESERVED_TEXT,
    STOP_TEXT,
    Allowance,
    CommandQuota,
)
from openrois.errors import OutOfResources

MANY = 1_000_000_000


def owner() -> Allowance:
    return Allowance("one application", MANY, MANY)


@pytest.mark.parametrize(
    ("count", "text", "reason"),
    [
        (MAX_OF_SUBJECT, 0, f"one subject has at most {MAX_OF_SUBJECT} unfinished commands"),
        (2, MAX_TEXT_OF_SUBJECT, f"at most {MAX_TEXT_OF_SUBJECT} bytes are kept .* of one subject"),
    ],
)
def test_one_subject_has_a_share(count: int, text: int, reason: str) -> None:
    budget = CommandQuota()
    taken = budget.accept_commands(owner(), count, text, "ann")
    own = owner()
    with pytest.raises(OutOfResources, match=reason):
        budget.accept_commands(own, 1, 1, "ann")
    assert (own.taken, own.text, budget.taken, budget.text) == (0, 0, count, text)
    budget.accept_commands(owner(), 1, 1, "bob")
    budget.accept_commands(owner(), 1, 1, None)
    for _ in range(count):
        taken.end_one()
    budget.accept_commands(own, 1, 1, "ann")


@pytest.mark.parametrize("text", [0, 4096])
def test_however_many_take_all_they_can_the_next_finds_something(text: int) -> None:
    budget, taken = CommandQuota(), []

    def fill(subject: str) -> int:
        """Take until no more is given; return how often there was something."""
        for times in range(MAX_OF_SUBJECT + 1):
            try:
                taken.append(budget.accept_commands(owner(), 1, text, subject))
            except OutOfResources:
                return times
        raise AssertionError

    shares = [fill(f"subject {number}") for number in range(64)]
    assert shares[:4] == [3072, 2304, 1728, 1296]
    assert fill("subject 0") == 0
    assert {fill(f"new subject {number}") for number in range(400)} == {FIRST_OF_SUBJECT}
    budget.accept_commands(owner(), 1, STOP_TEXT, "subject 1", beyond=1)


@pytest.mark.parametrize("text", [0, FIRST_TEXT_OF_SUBJECT // FIRST_OF_SUBJECT])
def test_what_is_reserved_is_for_the_first_commands_of_each_subject(text: int) -> None:
    budget, taken = CommandQuota(), []
    # Whatever has filled the rest.
    taken.append(budget.accept_commands(owner(), budget.most - RESERVED, budget.most_text - RESERVED_TEXT))
    subjects = [f"subject {number}" for number in range(RESERVED // FIRST_OF_SUBJECT)]
    for subject in subjects:
        for _ in range(FIRST_OF_SUBJECT):
            taken.append(budget.accept_commands(owner(), 1, text, subject))
        with pytest.raises(OutOfResources, match="a smaller share than usual"):
            budget.accept_commands(owner(), 1, 1, subject)
    with pytest.raises(OutOfResources, match="the engine has at most"):
        budget.accept_commands(owner(), 1, 0, "one subject more")
    taken[-1].end_one()
    budget.accept_commands(owner(), 1, text, subjects[-1])


def test_a_first_command_that_is_too_long_has_no_share_of_what_is_reserved() -> None:
    budget = CommandQuota()
    budget.accept_commands(owner(), 1, budget.most_text - RESERVED_TEXT)
    with pytest.raises(OutOfResources, match="a smaller share than usual"):
        budget.accept_commands(owner(), 1, FIRST_TEXT_OF_SUBJECT + 1, "ann")
    budget.accept_commands(owner(), 1, FIRST_TEXT_OF_SUBJECT, "ann")


def test_the_only_subject_has_the_whole() -> None:
    budget = CommandQuota()
    budget.accept_commands(owner(), budget.most, budget.most_text)
    with pytest.raises(OutOfResources, match="the engine has at most"):
        budget.accept_commands(owner(), 1)


def test_unused_shares_are_dropped() -> None:
    budget = CommandQuota()
    for number in range(100):
        taken = budget.accept_commands(owner(), 1, 1, f"subject {number}")
        assert len(budget._shares) <= 2
        taken.end_one()
    del taken
    assert len(budget._shares) == 0


def test_a_stop_is_taken_when_nothing_else_is() -> None:
    budget, own = CommandQuota(most=2, most_text=100), Allowance("one application", 2, 100)
    budget.accept_commands(own, 2, 100)
    budget.accept_commands(own, 1, STOP_TEXT, "ann", beyond=1)
    with pytest.raises(OutOfResources):
        budget.accept_commands(own, 1, 0, "ann", beyond=1)
