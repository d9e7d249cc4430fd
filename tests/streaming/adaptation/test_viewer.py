from openrois_streaming.adaptation.budget import BURST, START
from openrois_streaming.adaptation.rung import ladder
from openrois_streaming.adaptation.viewer import VIDEO_SHARE, Adaptation, Caps, Standing

RUNGS = ladder(1280, 720, 30)
ALONE = tuple(Standing(rung, rung.min_bitrate) for rung in RUNGS)
BESIDE_FAST = (Standing(RUNGS[0], 0.9 * 2_500_000), *ALONE[1:])


class Following:
    """An adaptation on a clock that the test turns, with a path that carries so many bit/s."""

    def __init__(
        self,
        caps: Caps | None = None,
        start: float | None = None,
        standings: tuple[Standing, ...] = ALONE,
        carried: float = 100_000_000,
    ) -> None:
        self.now = 0.0
        self.carried = carried
        self.adaptation = Adaptation(caps or Caps(), self.now, start)
        self.decision = self.adaptation.decide(standings, self.now)

    def live(self, seconds: float, standings: tuple[Standing, ...] = ALONE) -> None:
        path = self.adaptation.path
        for _ in range(round(seconds * 10)):
            self.now += 0.1
            path.sent(round(self.decision.demand / 80), self.now)
            if path.question is not None:
                path.burst(self.now)
                path.answered(path.question * BURST, path.question * BURST / self.carried, self.now)
            self.decision = self.adaptation.decide(standings, self.now)

    def becomes(self, carried: float) -> None:
        """The viewer says that its path carries no more than that."""
        self.carried = carried
        self.adaptation.path.estimated(10 * carried, self.now)
        self.adaptation.path.estimated(carried, self.now)


def test_a_viewer_alone_begins_with_the_best_picture_at_a_rate_that_most_paths_carry() -> None:
    following = Following()
    assert (following.decision.index, following.decision.demand) == (0, START * VIDEO_SHARE)
    assert not following.decision.stills


def test_measured_path_begins_with_its_rate() -> None:
    assert Following(start=300_000).decision.index == 1
    assert Following(start=5_000_000).decision.demand == 5_000_000 * VIDEO_SHARE


def test_beside_fast_ones_it_begins_lower_and_is_on_top_within_a_second() -> None:
    following = Following(standings=BESIDE_FAST)
    assert following.decision.index == 1
    following.live(0.5, BESIDE_FAST)
    assert following.decision.index == 0
    assert following.decision.demand >= 2_500_000 * 0.99


def test_slow_viewer_stays_below_the_fast_ones() -> None:
    following = Following(standings=BESIDE_FAST, carried=1_000_000)
    following.live(60, BESIDE_FAST)
    assert (following.decision.index, following.adaptation.switches) == (1, 0)


def test_when_the_path_carries_less_it_goes_down_at_once_and_in_the_end_to_stills() -> None:
    following = Following()
    following.live(3)
    for carried, index, stills in ((400_000, 1, False), (120_000, 2, False), (31_000, 2, True)):
        following.becomes(carried)
        following.live(0.1)
        assert (following.decision.index, following.decision.stills) == (index, stills)
        following.live(2)
    assert following.adaptation.switches == 2


def test_a_rung_that_was_too_much_is_left_alone_for_a_while_and_longer_the_second_time() -> None:
    crowded = (Standing(RUNGS[0], 3_500_000), *ALONE[1:])
    following = Following()
    following.live(3)
    waited = []
    for _ in range(2):
        following.live(0.1, crowded)
        assert following.decision.index == 1
        since = following.now
        while following.decision.index == 1:
            following.live(0.1)
        waited.append(round(following.now - since))
    assert waited == [8, 16]


def test_up_needs_more_than_to_stay() -> None:
    following = Following(Caps(max_bitrate=850_000))
    following.live(1)
    assert following.decision.index == 0
    just = (Standing(RUNGS[0], 720_000), *ALONE[1:])
    following.live(20, just)
    assert following.decision.index == 0
    following.live(1, (Standing(RUNGS[0], 800_000), *ALONE[1:]))
    assert following.decision.index == 1
    following.live(60, just)
    assert following.decision.index == 1
    following.live(1, (Standing(RUNGS[0], 660_000), *ALONE[1:]))
    assert following.decision.index == 0


def test_caps_hold_whatever_the_path_carries() -> None:
    following = Following(Caps(max_bitrate=500_000))
    following.live(5)
    assert following.decision.demand == 500_000 * VIDEO_SHARE
    small = Following(Caps(height=360))
    small.live(5)
    assert (small.decision.index, small.adaptation.switches) == (1, 0)
    assert Following(Caps(width=10)).decision.index == 2, "the smallest there is"
    small.adaptation.caps = Caps(height=180)
    small.live(0.1)
    assert small.decision.index == 2


def test_of_two_limits_the_lower_one_holds() -> None:
    assert Caps().within(Caps()) == Caps()
    one, other = Caps(1_000_000, 640, None, 30.0), Caps(500_000, 1280, 360)
    assert one.within(other) == other.within(one) == Caps(500_000, 640, 360, 30.0)


def test_a_size_is_admitted_if_both_its_sides_fit() -> None:
    rungs = ladder(1280, 720, 30)
    assert [Caps().admits(rung) for rung in rungs] == [True, True, True]
    assert [Caps(width=640).admits(rung) for rung in rungs] == [False, True, True]
    assert [Caps(height=359).admits(rung) for rung in rungs] == [False, False, True]
