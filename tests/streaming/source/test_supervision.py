import pytest
from openrois_streaming.source.supervision import CHECK_INTERVAL, HUNG, QUIET, Pace, SourceWatch


class Collector:
    """Looks at a source as often as it has to be."""

    def __init__(self) -> None:
        self.now = 100.0
        self.last: float | None = None
        self.wanted = True
        self.watch = SourceWatch(self.now)

    def after(self, seconds: float) -> Pace:
        """The pace, `seconds` later."""
        pace = Pace.WELL
        end = self.now + seconds
        while self.now < end:
            self.now = min(end, self.now + CHECK_INTERVAL)
            pace = self.watch.judge(self.now, self.last, wanted=self.wanted)
        return pace


@pytest.fixture
def looking() -> Collector:
    return Collector()


def test_a_source_that_stalls_is_noticed_within_a_second_and_one_that_hangs_within_five(looking: Collector) -> None:
    looking.last = 100.0
    assert looking.after(QUIET - 0.01) is Pace.WELL
    assert looking.after(0.02) is Pace.QUIET
    assert looking.after(HUNG - QUIET - 0.02) is Pace.QUIET
    assert looking.after(0.02) is Pace.HUNG
    looking.last = looking.now
    assert looking.after(CHECK_INTERVAL) is Pace.WELL


def test_a_source_that_never_gives_anything_is_judged_from_when_it_is_wanted(looking: Collector) -> None:
    looking.wanted = False
    assert looking.after(100) is Pace.WELL
    looking.wanted = True
    assert looking.after(QUIET - 0.01) is Pace.WELL
    assert looking.after(0.02) is Pace.QUIET


def test_a_frame_from_before_it_was_wanted_is_no_sign_of_life_and_no_fault(looking: Collector) -> None:
    looking.last = 1.0
    assert looking.after(QUIET - 0.01) is Pace.WELL
    assert looking.after(0.02) is Pace.QUIET


def test_standstill_of_the_process_does_not_count(looking: Collector) -> None:
    looking.last = looking.now
    looking.after(0.5)
    looking.now += 20
    assert looking.watch.judge(looking.now, looking.last) is Pace.WELL
    assert looking.after(QUIET - 0.01) is Pace.WELL
    assert looking.after(0.02) is Pace.QUIET
