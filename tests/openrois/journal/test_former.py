import pytest

from openrois.errors import ComponentFailed
from openrois.journal.former import RESTARTED, FormerCommand, FormerCommands
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

GIVEN = (Result(name="total", data_type_ref="integer", value="3"),)


def test_one_that_ran_has_failed() -> None:
    command = FormerCommand("robot/lamp", None, RESTARTED, None)
    assert command.completed_status is CompletedStatus.ERROR
    with pytest.raises(ComponentFailed, match=RESTARTED):
        command.results()


def test_one_that_had_ended_gives_what_it_gave() -> None:
    command = FormerCommand("robot/lamp", CompletedStatus.OK, "", GIVEN)
    assert (command.completed_status, command.results()) == (CompletedStatus.OK, GIVEN)


def test_what_was_too_long_is_missed_with_a_word() -> None:
    with pytest.raises(ComponentFailed, match="too long"):
        FormerCommand("robot/lamp", CompletedStatus.OK, "", None).results()


def test_commands_belong_to_their_subject_and_the_oldest_are_dropped() -> None:
    former = FormerCommands(2)
    commands = [FormerCommand("robot/lamp", None, str(number), None) for number in range(4)]
    former.put("ann", "1", commands[0])
    former.put("bob", "1", commands[1])
    former.put("ann", "1", commands[2])
    assert former.find("ann", "1") is commands[2]
    assert former.find("bob", "1") is commands[1]
    former.put("ann", "2", commands[3])
    assert len(former) == 2
    assert former.find("bob", "1") is None
