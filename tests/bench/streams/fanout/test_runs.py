from itertools import pairwise
from typing import Any

import pytest
from openrois_bench.streams.fanout.runs import AIORTC, CODECS, OPENROIS, WAYS, Planned, Reading, Run, compare, plan


def test_every_cell_runs_in_every_round_once_each_way() -> None:
    planned = plan(3, (1, 4))
    assert len(set(planned)) == len(planned) == 3 * len(CODECS) * 2 * len(WAYS)


def test_compared_runs_are_adjacent_and_alternate() -> None:
    planned = plan(2, (1, 4))
    for first, second in list(pairwise(planned))[::2]:
        assert first[:3] == second[:3]
        assert [first.way, second.way] == ([OPENROIS, AIORTC] if first.round == 0 else [AIORTC, OPENROIS])


def reading(at: float, cpu: float, pictures: list[int], received: list[int], busy: float | None) -> Reading:
    receivers: dict[str, Any] = {"at": at, "cpu": cpu / 10, "pictures": pictures, "bytes": received}
    return Reading({"at": at, "cpu": cpu, "encoders": 1}, receivers, busy)


def counted(viewers: int, pictures: list[int], busy: float | None = 2.15) -> Run:
    planned = Planned(0, "video/VP8", viewers, OPENROIS)
    before = reading(10.0, 5.0, [100, 50], [0, 0], None if busy is None else 100.0)
    after = [100 + pictures[0], 50 + pictures[1]]
    return Run.of(planned, before, reading(12.0, 5.5, after, [250_000, 250_000], None if busy is None else 100 + busy))


def test_a_run_is_the_difference_of_two_readings() -> None:
    run = counted(2, [60, 54])
    assert (run.cpu, run.fps, run.encoders) == (0.25, (30.0, 27.0), 1)
    assert run.kbps == 1000
    assert run.delivered


def test_other_load_is_machine_load_beyond_the_bench() -> None:
    # In these two seconds the sender used 0.5 s and the receivers 0.05 s.
    assert counted(2, [60, 60], busy=2.15).others == 0.8
    # The kernel counts in steps of 10 ms.
    assert counted(2, [60, 60], busy=0.54).others == 0
    assert counted(2, [60, 60], busy=None).others is None


def test_a_run_has_not_delivered_when_one_viewer_got_too_little() -> None:
    assert not counted(2, [60, 53]).delivered


def test_viewers_that_do_not_play_do_not_count() -> None:
    run = counted(1, [60, 0])
    assert run.fps == (30.0,)
    assert run.delivered


def run(number: int, way: str, cpu: float, *, delivered: bool = True, viewers: int = 2) -> Run:
    fps = (30.0, 30.0 if delivered else 3.0)
    return Run(
        round=number,
        codec="video/VP8",
        viewers=viewers,
        way=way,
        cpu=cpu,
        encoders=1 if way == OPENROIS else viewers,
        fps=fps,
        kbps=900 + number,
        delivered=delivered,
        others=None,
    )


def test_rounds_are_summed_up_by_their_medians_and_ratios_within_a_round() -> None:
    # Round 1 is on a busy machine: both cost twice as much, and the ratio is the same.
    costs = [(OPENROIS, 0.1, 0.2, 0.12), (AIORTC, 0.4, 0.8, 0.4)]
    runs = [run(number, way, cpu) for way, *each in costs for number, cpu in enumerate(each)]
    (found,) = compare(runs[::-1])
    assert found.cpu == {OPENROIS: 0.12, AIORTC: 0.4}
    assert found.ratio == 0.25
    assert found.fps == {OPENROIS: 30.0, AIORTC: 30.0}
    assert found.kbps == {OPENROIS: 901, AIORTC: 901}
    assert found.encoders == {OPENROIS: 1, AIORTC: 2}
    assert found.delivered == {OPENROIS: True, AIORTC: True}


def test_a_round_in_which_one_did_not_deliver_says_nothing_about_the_ratio() -> None:
    runs = [run(0, OPENROIS, 0.1), run(0, AIORTC, 0.1, delivered=False), run(1, OPENROIS, 0.1), run(1, AIORTC, 0.5)]
    (found,) = compare(runs)
    assert found.ratio == 0.2
    assert found.delivered == {OPENROIS: True, AIORTC: False}
    (found,) = compare(runs[:2])
    assert found.ratio is None


def test_numbers_of_viewers_are_kept_apart() -> None:
    runs = [run(0, way, 0.1, viewers=viewers) for viewers in (2, 4) for way in WAYS]
    assert [each.viewers for each in compare(runs)] == [2, 4]


@pytest.mark.parametrize("way", WAYS)
def test_a_missing_counterpart_is_a_fault(way: str) -> None:
    with pytest.raises(ValueError, match="zip"):
        compare([run(0, OPENROIS, 0.1), run(0, AIORTC, 0.1), run(1, way, 0.1)])
