"""Whether a parent has attached an engine."""

import pytest

from openrois.remote.attachment import ATTACHED, Attachment


@pytest.fixture
def told() -> list[bool]:
    return []


@pytest.fixture
def attachment(told: list[bool]) -> Attachment:
    return Attachment(told.append)


def test_a_parent_that_will_say_so_is_waited_for(attachment: Attachment, told: list[bool]) -> None:
    attachment.greet(("rois.stream", ATTACHED))
    attachment.assume(was_asked=True)
    assert told == []
    attachment.confirm()
    attachment.confirm()
    attachment.connection_ended()
    attachment.connection_ended()
    assert told == [True, False]


def test_one_that_greets_and_will_not_has_taken_it_in(attachment: Attachment, told: list[bool]) -> None:
    attachment.greet(("rois.stream",))
    attachment.greet(("rois.stream",))
    assert told == [True]


def test_one_of_the_base_wire_is_known_by_its_questions(attachment: Attachment, told: list[bool]) -> None:
    attachment.assume(was_asked=False)
    assert told == []
    attachment.assume(was_asked=True)
    assert told == [True]


def test_one_that_never_took_it_in_is_not_missed(attachment: Attachment, told: list[bool]) -> None:
    attachment.connection_ended()
    assert told == []
