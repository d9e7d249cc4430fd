"""What an application has at other gateways, and what is left of it when one of them is lost."""

import pytest

from openrois.errors import BadParameter, OutOfResources
from openrois.federation.foreign_work import MAX_KEPT, MAX_RUNNING, ForeignWork, Lost

COMPLETED = "rois.command.completed"
STATUS = "rois.stream.notify_stream_status"


@pytest.fixture
def work() -> ForeignWork:
    return ForeignWork()


class TestCommands:
    def test_a_command_has_one_end(self, work: ForeignWork) -> None:
        work.begin("a", {"1": "robot/lamp"})
        assert "1" in work
        assert work.running == 1
        assert work.gateway_of_command("1") == "a"
        assert work.note_notification("a", COMPLETED, {"command_id": "1"})
        assert not work.note_notification("a", COMPLETED, {"command_id": "1"}), "a second end goes nowhere"
        assert work.running == 0
        assert work.gateway_of_command("1") == "a", "its results are there"
        assert work.gateway_of_command("2") is None

    def test_an_id_is_used_once(self, work: ForeignWork) -> None:
        work.begin("a", {"1": "robot/lamp"})
        with pytest.raises(BadParameter, match="'1' is empty or taken"):
            work.begin("b", {"2": "arm/hand", "1": "arm/hand"})
        assert "2" not in work
        work.note_notification("a", COMPLETED, {"command_id": "1"})
        with pytest.raises(BadParameter):
            work.begin("a", {"1": "robot/lamp"})

    def test_what_was_not_accepted_is_free_again(self, work: ForeignWork) -> None:
        work.begin("a", {"1": "robot/lamp"})
        work.give_up(["1", "unknown"])
        work.begin("a", {"1": "robot/lamp"})

    def test_commands_at_other_gateways_are_bounded(self, work: ForeignWork) -> None:
        work.begin("a", {str(number): "robot/lamp" for number in range(MAX_RUNNING)})
        with pytest.raises(OutOfResources, match=f"at most {MAX_RUNNING} commands at other gateways"):
            work.begin("a", {"more": "robot/lamp"})

    def test_those_of_a_resumed_session_are_ended_here(self, work: ForeignWork) -> None:
        work.adopt("a", ["1"])
        reason = {"command_id": "1", "reason": "why"}
        assert work.note_notification("a", "openrois.reason", reason)
        assert work.note_notification("a", COMPLETED, {"command_id": "1"})
        assert not work.note_notification("a", "openrois.reason", reason), "it stands before no end"


class TestOthers:
    def test_the_gateway_of_a_request_is_known(self, work: ForeignWork) -> None:
        assert work.note_notification("a", "openrois.lease.requested", {"request_id": "r"})
        assert work.note_notification("a", "openrois.lease.requested", {})
        assert work.gateway_of_request("r") == "a"
        assert work.gateway_of_request("other") is None

    def test_what_is_held_is_known_by_answers_and_notifications(self, work: ForeignWork) -> None:
        work.note_held("robot/lamp", is_held=True)
        work.note_held("robot/door", is_held=False)
        assert work.held == {"robot/lamp"}
        changed = "openrois.lease.changed"
        assert work.note_notification("a", changed, {"component_ref": "robot/arm", "state": "MINE"})
        assert work.note_notification("a", changed, {"component_ref": "robot/lamp", "state": "HELD"})
        assert work.held == {"robot/arm"}
        for number in range(MAX_KEPT):
            work.note_held(f"robot/{number}", is_held=True)
        assert len(work.held) == MAX_KEPT

    def test_streams_end_by_their_status(self, work: ForeignWork) -> None:
        work.note_stream("a", "s", "robot/camera")
        assert work.note_notification("a", STATUS, {"stream_id": "s", "status": "STREAMING_RUNNING"})
        assert work.lose("b") == Lost({}, {})
        assert work.note_notification("a", STATUS, {"stream_id": "s", "status": "STREAMING_NOT_CONNECTED"})
        assert work.lose("a") == Lost({}, {})

    def test_all_else_goes_on(self, work: ForeignWork) -> None:
        assert work.note_notification("a", "rois.event.notify_event", {})
        assert work.note_notification("a", "openrois.reason", {"request_id": 1, "reason": "why"})


def test_a_gateway_is_lost_with_all_that_was_there_and_nothing_else(work: ForeignWork) -> None:
    work.begin("a", {"1": "robot/lamp"})
    work.begin("b", {"2": "arm/hand"})
    work.note_stream("a", "s", "robot/camera")
    work.note_stream("b", "t", "arm/camera")
    assert work.lose("a") == Lost({"1": "robot/lamp"}, {"s": "robot/camera"})
    assert "1" not in work
    assert "2" in work
    assert not work.note_notification("a", COMPLETED, {"command_id": "1"}), "it has had its end"
