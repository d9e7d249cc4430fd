import pytest
from openrois_streaming.liveness import STALL, Verdict
from openrois_streaming.peer.arrival import Arrival, both


def test_nothing_is_known_while_nothing_is_wanted() -> None:
    arrival = Arrival()
    assert arrival.judge(10.0, 10.0) is Verdict.UNDECIDED
    arrival.opened(10.0)
    arrival.closed()
    assert arrival.judge(20.0, 20.0) is Verdict.UNDECIDED


@pytest.mark.parametrize("last", [None, 9.0])
def test_the_first_frame_has_its_time(last: float | None) -> None:
    arrival = Arrival()
    arrival.opened(10.0)
    assert arrival.judge(10.0 + STALL / 2, last) is Verdict.UNDECIDED
    assert arrival.judge(10.0 + STALL, last) is Verdict.STALLED


def test_it_flows_as_long_as_frames_come() -> None:
    arrival = Arrival()
    arrival.opened(10.0)
    assert arrival.judge(10.5, 10.4) is Verdict.FLOWING
    assert arrival.judge(10.4 + STALL, 10.4) is Verdict.STALLED
    assert arrival.judge(30.0, 29.9) is Verdict.FLOWING


@pytest.mark.parametrize(
    ("verdicts", "together"),
    [
        ([], Verdict.UNDECIDED),
        ([Verdict.FLOWING], Verdict.FLOWING),
        ([Verdict.FLOWING, Verdict.STALLED], Verdict.STALLED),
        ([Verdict.UNDECIDED, Verdict.STALLED], Verdict.STALLED),
        ([Verdict.UNANSWERED, Verdict.FLOWING], Verdict.UNANSWERED),
        ([Verdict.FLOWING, Verdict.UNDECIDED], Verdict.UNDECIDED),
        ([Verdict.FLOWING, Verdict.FLOWING], Verdict.FLOWING),
    ],
)
def test_both_directions_count(verdicts: list[Verdict], together: Verdict) -> None:
    assert both(verdicts) is together
