from collections.abc import Callable

import pytest
from openrois_streaming.adaptation.budget import BURST, LEAST, START, PathBudget
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.testing.link import Impairments

from tests.support.simulated_path import SimulatedViewer

FAST = Impairments(delay=0.02)


def pictures(highest: float) -> Callable[[float], float]:
    """The rate of a rendition that follows its viewer up to `highest`."""
    return lambda share: min(share, highest)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("loss", [0.0, 0.05])
def test_a_path_of_one_megabit_is_used_well_and_its_queue_stays_short(seed: int, loss: float) -> None:
    viewer = SimulatedViewer(Impairments(rate=1_000_000, delay=0.02, loss=loss), media=pictures(884_000), seed=seed)
    viewer.run(40)
    assert 600_000 < viewer.median_budget(since=5) < 900_000
    assert viewer.median_delay() < 0.055, "20 ms of the path, and about as much for a picture to pass"
    assert viewer.link.figures().dropped <= 5


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    "impairments", [FAST, Impairments(delay=0.02, loss=0.05), Impairments(delay=0.02, jitter=0.01)]
)
def test_a_fast_path_is_found_out_within_a_second_and_random_loss_does_not_matter(
    impairments: Impairments, seed: int
) -> None:
    viewer = SimulatedViewer(impairments, media=pictures(884_000), seed=seed)
    viewer.run(1)
    assert viewer.budget.budget == viewer.wanted
    viewer.run(30)
    assert viewer.budget.budget == viewer.wanted


@pytest.mark.parametrize("seed", [1, 2])
def test_a_path_that_becomes_slow_is_noticed_at_once(seed: int) -> None:
    viewer = SimulatedViewer(Impairments(rate=4_000_000, delay=0.02), media=pictures(2_500_000), seed=seed)
    viewer.run(10)
    assert viewer.budget.budget > 2_000_000
    viewer.change(Impairments(rate=700_000, delay=0.02))
    viewer.run(2)
    assert viewer.budget.budget < 750_000
    viewer.run(15)
    assert viewer.median_delay(since=13) < 0.08


def test_a_path_that_becomes_fast_is_noticed_after_the_longest_pause_at_the_latest() -> None:
    viewer = SimulatedViewer(Impairments(rate=700_000, delay=0.02), media=pictures(2_500_000))
    viewer.run(20)
    assert viewer.budget.budget < 750_000
    viewer.change(FAST)
    viewer.run(34)
    assert viewer.budget.budget == viewer.wanted


def test_a_very_slow_path_keeps_moving() -> None:
    viewer = SimulatedViewer(Impairments(rate=300_000, delay=0.05), media=pictures(884_000))
    viewer.run(40)
    assert viewer.median_delay(since=10) < 0.12
    assert viewer.median_budget(since=5) < 300_000


class Path:
    """A budget on a clock that the test turns; what is sent is what it allows."""

    def __init__(self, start: float | None = None) -> None:
        self.now = 0.0
        self.budget = PathBudget(0.0, start)
        self.sequence = 0

    def pass_time(self, seconds: float, *, wanted: float = 0.0) -> None:
        for _ in range(round(seconds * 10)):
            self.now = round(self.now + 0.1, 3)
            self.budget.sent(round(self.budget.budget / 80), self.now)
            self.sequence += 20
            self.budget.tick(wanted, self.now)

    def report(self, lost: int = 0, rtt: float | None = 0.02) -> None:
        self.budget.reported(ReceiverReport(self.sequence, 0.0, lost, 0), rtt, self.now)

    def answer(self, carried: float) -> None:
        """A burst shows that the path carries so much."""
        assert self.budget.question is not None
        bits = self.budget.question * BURST
        self.budget.burst(self.now)
        self.budget.answered(bits, bits / carried, self.now)


def test_no_probe_beyond_the_wanted_rate() -> None:
    path = Path()
    path.pass_time(5)
    assert (path.budget.question, path.budget.budget) == (None, START)


def test_at_first_all_that_is_wanted_is_in_question_and_it_is_had_if_it_is_carried() -> None:
    path = Path()
    path.pass_time(0.1, wanted=3_000_000)
    assert path.budget.question is None, "the first picture has the path for itself"
    path.pass_time(0.1, wanted=3_000_000)
    assert path.budget.question == 3_000_000
    path.answer(50_000_000)
    assert (path.budget.budget, path.budget.question) == (3_000_000, None)


def test_budget_stays_below_the_rate_of_a_burst() -> None:
    path = Path()
    path.pass_time(0.2, wanted=3_000_000)
    path.answer(2_000_000)
    assert 1_400_000 < path.budget.budget < 1_700_000


@pytest.mark.parametrize(("carried", "budget"), [(800_000, 616_000), (200_000, START / 2)])
def test_a_first_burst_may_lower_it_but_not_by_much(carried: float, budget: float) -> None:
    path = Path()
    path.pass_time(0.2, wanted=3_000_000)
    path.answer(carried)
    assert path.budget.budget == pytest.approx(budget)


def test_a_later_one_does_not() -> None:
    path = Path(1_000_000)
    path.pass_time(0.2, wanted=3_000_000)
    assert path.budget.question == 2_000_000, "twice of what is known"
    path.answer(200_000)
    assert path.budget.budget == 1_000_000


def test_questions_without_a_good_answer_are_repeated_after_longer_and_longer_pauses() -> None:
    path = Path()
    pauses, since = [], 0.0
    for _ in range(6):
        while path.budget.question is None:
            path.pass_time(0.1, wanted=3_000_000)
        pauses.append(round(path.now - since))
        since = path.now
        path.budget.answered(0, None, path.now)
    assert pauses == [0, 4, 8, 16, 32, 32]
    assert path.budget.budget == START
    path.pass_time(32.1, wanted=3_000_000)
    path.answer(50_000_000)
    path.pass_time(0.1, wanted=4_000_000)
    assert path.budget.question == 4_000_000, "one good answer and there is no pause"


def test_lost_burst_rate_lengthens_the_pause() -> None:
    path = Path(1_000_000)
    path.pass_time(0.2, wanted=2_000_000)
    path.answer(50_000_000)
    path.pass_time(2, wanted=2_000_000)
    path.budget.estimated(1_000_000, path.now)
    assert path.budget.budget == 1_000_000
    path.budget.tick(2_000_000, path.now + 4)
    path.answer(50_000_000)
    path.pass_time(2, wanted=2_000_000)
    path.budget.estimated(3_000_000, path.now)
    path.budget.estimated(1_000_000, path.now)
    path.budget.tick(2_000_000, path.now + 4)
    assert path.budget.question is not None


def test_complaints_right_after_a_burst_are_about_the_burst() -> None:
    path = Path(1_000_000)
    path.pass_time(2.0, wanted=2_000_000)
    path.answer(100_000)
    path.pass_time(0.5)
    path.budget.estimated(300_000, path.now)
    path.report(lost=30, rtt=0.5)
    assert path.budget.budget == 1_000_000


def test_the_first_complaint_of_what_arrives_being_late_may_be_a_jolt() -> None:
    path = Path(1_000_000)
    path.pass_time(5)
    for estimate in (1_500_000, 930_000, 900_000):
        path.budget.estimated(estimate, path.now)
    assert path.budget.budget == 1_000_000
    path.pass_time(0.5)
    path.budget.estimated(1_500_000, path.now)
    path.budget.estimated(910_000, path.now)
    assert path.budget.budget == 910_000


def test_a_second_one_that_comes_late_is_a_first_one_again() -> None:
    path = Path(1_000_000)
    for _ in range(3):
        path.pass_time(3)
        path.budget.estimated(1_500_000, path.now)
        path.budget.estimated(860_000, path.now)
    assert path.budget.budget == 1_000_000


def test_complaint_without_a_queue_is_not_believed() -> None:
    path = Path(1_000_000)
    path.report(rtt=0.02)
    for _ in range(6):
        path.pass_time(0.5)
        path.report(rtt=0.03)
        path.budget.estimated(1_500_000, path.now)
        path.budget.estimated(830_000, path.now)
    assert path.budget.budget == 1_000_000


def test_a_first_estimate_far_below_what_is_sent_counts() -> None:
    path = Path(1_000_000)
    path.pass_time(2)
    path.budget.estimated(500_000, path.now)
    assert path.budget.budget == 500_000
    fine = Path(1_000_000)
    fine.pass_time(2)
    fine.budget.estimated(990_000, fine.now)
    assert (fine.budget.budget, fine.budget.estimate) == (1_000_000, 990_000)


def test_estimates_after_a_complaint_only_lower_the_budget() -> None:
    path = Path(1_000_000)
    path.pass_time(2)
    path.budget.estimated(600_000, path.now)
    path.budget.estimated(550_000, path.now)
    path.pass_time(0.5)
    path.budget.estimated(900_000, path.now)
    path.budget.estimated(800_000, path.now)
    assert path.budget.budget == 550_000


def test_an_estimate_that_stays_below_what_is_sent_is_believed_in_the_end() -> None:
    path = Path(1_000_000)
    path.budget.estimated(700_000, path.now)
    path.pass_time(3.0)
    assert path.budget.budget == 1_000_000
    path.pass_time(0.3)
    assert path.budget.budget == 700_000


def test_an_estimate_has_time_to_follow_what_a_burst_has_shown() -> None:
    path = Path(60_000)
    path.budget.estimated(60_000, path.now)
    path.pass_time(10.0)
    path.pass_time(0.1, wanted=1_000_000)
    path.answer(50_000_000)
    path.pass_time(3.0)
    assert path.budget.budget == 120_000
    path.pass_time(0.3)
    assert path.budget.budget == 60_000, "it has not followed"


@pytest.mark.parametrize(("lost", "rtt"), [(80, 0.02), (0, 0.5)])
def test_heavy_loss_or_a_long_queue_lower_it_without_an_estimate(lost: int, rtt: float) -> None:
    path = Path(1_000_000)
    path.report()
    path.pass_time(2)
    path.report(lost=lost, rtt=rtt)
    lowered = path.budget.budget
    assert 600_000 < lowered < 900_000
    path.pass_time(0.5)
    path.report(lost=lost, rtt=rtt)
    assert path.budget.budget == lowered, "it is about what was sent before"


def test_a_report_may_lack_the_round_trip() -> None:
    path = Path()
    path.pass_time(2)
    path.report(rtt=None)
    assert (path.budget.queue, path.budget.round_trip_time) == (0.0, None)


def test_there_is_a_least() -> None:
    path = Path()
    path.pass_time(2)
    path.budget.estimated(1, path.now)
    assert path.budget.budget == LEAST
    assert PathBudget(0.0, 1).budget == LEAST


def complain(path: Path, *, rtt: bool) -> None:
    """Delay, from an estimate or a report."""
    if rtt:
        path.report(rtt=0.5)
    else:
        path.budget.estimated(1_500_000, path.now)
        path.budget.estimated(500_000, path.now)


@pytest.mark.parametrize("rtt", [False, True])
def test_a_complaint_of_delay_that_a_round_trip_does_not_confirm_is_taken_back(rtt: bool) -> None:
    path = Path(1_000_000)
    path.report()
    path.pass_time(2)
    assert not path.budget.doubtful(path.now)
    complain(path, rtt=rtt)
    assert path.budget.doubtful(path.now)
    assert path.budget.budget < 900_000, "meanwhile it is believed"
    path.budget.checked(0.03, path.now + 0.05)
    assert path.budget.budget == 1_000_000
    assert not path.budget.doubtful(path.now + 0.05)
    complain(path, rtt=rtt)
    assert path.budget.doubtful(path.now), "each complaint is looked at, and not taken for a part of the one before"


def test_a_complaint_that_is_confirmed_or_not_looked_at_in_time_stays() -> None:
    path = Path(1_000_000)
    path.budget.checked(0.0, path.now)
    path.pass_time(2)
    complain(path, rtt=False)
    path.budget.checked(0.06, path.now + 0.06)
    assert path.budget.doubtful(path.now + 0.07)
    path.budget.estimated(400_000, path.now + 0.08)
    path.budget.checked(0.0, path.now + 0.11)
    assert path.budget.budget == 400_000
    assert not path.budget.doubtful(path.now + 0.11), "however many complaints there are, the doubt ends"


def test_heavy_loss_is_not_in_doubt() -> None:
    path = Path(1_000_000)
    path.report()
    path.pass_time(2)
    path.report(lost=80)
    assert not path.budget.doubtful(path.now)
    path.budget.checked(0.0, path.now)
    assert path.budget.budget < 900_000


@pytest.mark.parametrize("rtt", [False, True])
def test_delay_by_a_standstill_is_ignored(rtt: bool) -> None:
    path = Path(1_000_000)
    path.report()
    path.pass_time(2)
    path.budget.stalled(path.now)
    complain(path, rtt=rtt)
    assert (path.budget.budget, path.budget.queue) == (1_000_000, 0)
    path.pass_time(0.6)
    path.budget.estimated(900_000, path.now)
    complain(path, rtt=rtt)
    assert path.budget.budget < 900_000
