"""Which commands have ended, from what the robot tells."""

from openrois_robots.kachaka.api.tracking import LOST_AFTER, Tracking


def test_a_command_that_runs_is_not_lost_however_long_it_takes() -> None:
    tracking = Tracking()
    tracking.begin("a", 0.0)
    tracking.note_current("a", 0.1)
    assert tracking.current == "a"
    assert "a" in tracking
    assert not tracking.misses
    assert tracking.lost(1000.0) == ()


def test_a_command_that_was_seen_and_runs_no_more_is_lost_after_a_while() -> None:
    tracking = Tracking()
    tracking.begin("a", 0.0)
    tracking.note_current("a", 0.1)
    tracking.note_current("b", 1.0)
    assert tracking.misses
    assert tracking.lost(1.0 + LOST_AFTER - 0.01) == ()
    tracking.note_current("", 1.2)
    assert tracking.lost(1.0 + LOST_AFTER + 0.01) == ("a",), "from when it was missed first"


def test_a_command_that_waits_behind_another_one_is_not_missed() -> None:
    tracking = Tracking()
    tracking.note_current("other", 0.0)
    tracking.begin("a", 0.1)
    tracking.note_current("third", 5.0)
    assert not tracking.misses
    assert tracking.lost(100.0) == ()


def test_a_command_that_never_ran_is_missed_while_nothing_runs() -> None:
    tracking = Tracking()
    tracking.begin("a", 0.0)
    assert tracking.misses
    tracking.note_current("a", 0.5)
    assert not tracking.misses, "it has begun after all"


def test_a_command_that_was_told_before_its_id_was_known_counts_as_seen() -> None:
    tracking = Tracking()
    tracking.note_current("a", 0.0)
    tracking.begin("a", 0.1)
    tracking.note_current("b", 1.0)
    assert tracking.lost(1.0 + LOST_AFTER) == ("a",)


def test_what_has_ended_is_forgotten() -> None:
    tracking = Tracking()
    tracking.begin("a", 0.0)
    assert len(tracking) == 1
    tracking.note_end("a")
    tracking.note_end("a")
    assert len(tracking) == 0
    assert tracking.lost(100.0) == ()
