"""How long a gateway has been in contact with the store."""

import pytest

from openrois.ownership.contact import Contact

pytestmark = pytest.mark.extra(name="base")

STORE = 1_900_000_000_000


def in_contact(*moments: float) -> Contact:
    """A contact with an answer at each moment; the clock of the store is ahead by 1,900,000,000 s."""
    contact = Contact(10.0)
    for moment in moments:
        contact.note_answer(moment, STORE + round(moment * 1000))
    return contact


def test_there_is_none_before_the_first_answer() -> None:
    assert in_contact().lasting(100.0) == 0


def test_it_lasts_from_the_first_answer_on() -> None:
    assert in_contact(100, 104, 109).lasting(110) == 10


def test_it_ends_half_a_time_out_after_the_last_answer() -> None:
    contact = in_contact(100, 104)
    assert (contact.lasting(109), contact.lasting(109.1)) == (9, 0)


def test_it_begins_anew_after_a_gap() -> None:
    assert in_contact(100, 104, 110, 113).lasting(114) == 4


def test_it_begins_anew_after_a_failure() -> None:
    contact = in_contact(100, 104)
    contact.break_off()
    assert contact.lasting(105) == 0
    contact.note_answer(105, STORE + 105_000)
    assert contact.lasting(107) == 2


@pytest.mark.parametrize(("step", "lasts"), [(3600, 0), (-3600, 0), (1.5, 0), (-1.5, 0), (0.9, 4), (-0.9, 4)])
def test_it_begins_anew_where_the_clock_of_the_store_was_stepped(step: float, lasts: float) -> None:
    contact = in_contact(100)
    contact.note_answer(104, STORE + 104_000 + round(step * 1000))
    assert contact.lasting(104) == lasts
