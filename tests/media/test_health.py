import pytest
from openrois_media.health import Health, Observed, Trouble, worst
from openrois_streaming.source.supervision import CHECK_INTERVAL, HUNG, QUIET

from openrois.types.codes import ComponentStatus, ErrorType

READY, WARNING, ERROR = ComponentStatus.READY, ComponentStatus.WARNING, ComponentStatus.ERROR
HANGS = Trouble(ErrorType.COMPONENT_NOT_RESPONDING, "the picture has given no frame for 5 s")


class Patient:
    """Something whose health is looked at as often as it has to be."""

    def __init__(self) -> None:
        self.now = 100.0
        self.health = Health("the picture", self.now)
        self.seen = Observed(self.now)
        self.reported: list[Trouble] = []

    def wait(self, seconds: float) -> ComponentStatus:
        end = self.now + seconds
        while self.now < end:
            self.now = min(end, self.now + CHECK_INTERVAL)
            trouble = self.health.judge(self.now, self.seen)
            if trouble is not None:
                self.reported.append(trouble)
        return self.health.status

    def plays(self) -> ComponentStatus:
        self.seen = Observed(self.now)
        return self.wait(CHECK_INTERVAL)


@pytest.fixture
def patient() -> Patient:
    return Patient()


def test_a_stall_is_a_warning_and_a_hang_an_error_that_is_reported_once(patient: Patient) -> None:
    assert patient.wait(QUIET - 0.01) is READY
    assert patient.wait(0.02) is WARNING
    assert (patient.wait(HUNG - QUIET), patient.reported) == (ERROR, [HANGS])
    assert (patient.wait(60), patient.reported) == (ERROR, [HANGS])
    assert patient.plays() is READY
    assert (patient.wait(HUNG + 1), patient.reported) == (ERROR, [HANGS, HANGS])


def test_a_failure_is_an_error_at_once_and_reported_once(patient: Patient) -> None:
    patient.seen = Observed(None, failure="the game engine is gone: killed")
    assert patient.wait(0.01) is ERROR
    assert patient.wait(60) is ERROR
    assert patient.reported == [Trouble(ErrorType.COMPONENT_INTERNAL_ERROR, "the game engine is gone: killed")]


def test_recovered_source_is_judged_after_its_grace(patient: Patient) -> None:
    patient.seen = Observed(None, failure="the game engine is gone")
    patient.wait(60)
    patient.seen = Observed(None)
    assert patient.wait(QUIET - 0.01) is READY
    assert patient.wait(0.02) is WARNING


def test_a_failure_that_turns_into_a_stall_is_still_the_same_trouble(patient: Patient) -> None:
    patient.wait(HUNG)
    patient.seen = Observed(patient.now - QUIET - 0.1)
    assert patient.wait(CHECK_INTERVAL) is WARNING
    assert (patient.wait(HUNG), len(patient.reported)) == (ERROR, 1)


def test_unwanted_source_stays_ready(patient: Patient) -> None:
    patient.seen = Observed(None, wanted=False)
    assert (patient.wait(60), patient.reported) == (READY, [])


def test_unplayed_source_has_not_recovered(patient: Patient) -> None:
    broken, unseen = Observed(None, failure="unplugged"), Observed(None, wanted=False, unseen=True)
    for _ in range(2):
        for patient.seen, status in ((broken, ERROR), (unseen, READY), (Observed(None), READY), (broken, ERROR)):
            assert (patient.wait(QUIET - 0.2), patient.health.missed) == (status, True)
    assert patient.reported == [Trouble(ErrorType.COMPONENT_INTERNAL_ERROR, "unplugged")]
    assert (patient.plays(), patient.health.missed) == (READY, False)
    patient.seen = broken
    assert (patient.wait(QUIET), len(patient.reported)) == (ERROR, 2)


def test_a_frame_from_before_the_trouble_is_no_return(patient: Patient) -> None:
    before = patient.now
    patient.seen = Observed(before, failure="unplugged")
    patient.wait(0.5)
    patient.seen = Observed(before)
    assert (patient.wait(0.1), patient.health.missed) == (READY, True)


def test_observable_source_recovers_without_frames(patient: Patient) -> None:
    for _ in range(2):
        patient.seen = Observed(None, wanted=False, failure="the game engine is gone")
        assert patient.wait(1.0) is ERROR
        patient.seen = Observed(None, wanted=False)
        assert (patient.wait(1.0), patient.health.missed) == (READY, False)
    assert len(patient.reported) == 2


def test_the_worst_of_several_counts() -> None:
    assert worst(READY) is READY
    assert worst(READY, WARNING) is worst(WARNING, READY) is WARNING
    assert worst(ERROR, READY, WARNING) is ERROR
