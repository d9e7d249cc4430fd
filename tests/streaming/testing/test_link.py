import itertools
from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.testing import link as module
from openrois_streaming.testing.link import OVERHEAD, Impairments, Link

pytestmark = pytest.mark.extra(name="streaming")

EIGHT_KBIT = b"x" * (1000 - OVERHEAD)  # 1000 bytes on the wire
"""Takes 8 ms at 1 Mbit/s."""


def numbered(count: int) -> list[bytes]:
    return [str(number).encode() for number in range(count)]


def passed(link: Link, datagrams: list[bytes], *, every: float = 0.001, until: float = 1e9) -> list[bytes]:
    """What comes out when these come in one after the other."""
    arrived = []
    for number, datagram in enumerate(datagrams):
        link.push(datagram, number * every)
        arrived += link.pop(number * every)
    return arrived + link.pop(until)


class TestImpairments:
    @pytest.mark.parametrize(
        "wrong",
        [
            {"loss": 1.1},
            {"reorder": -0.1},
            {"duplicate": float("nan")},
            {"delay": -1},
            {"jitter": float("inf")},
            {"queue": float("nan")},
            {"queue_bytes": -1},
            {"rate": 0},
            {"rate": float("nan")},
            {"burst": 0.5},
        ],
        ids=str,
    )
    def test_impairments_out_of_range_are_refused(self, wrong: dict[str, float]) -> None:
        with pytest.raises(ValueError, match=next(iter(wrong)) if wrong != {"loss": 1.1} else "share"):
            Impairments(**wrong)  # type: ignore[arg-type]

    def test_room_follows_the_rate_or_the_setting(self) -> None:
        assert Impairments().room == float("inf")
        assert Impairments(rate=1_000_000, queue=0.1).room == 12_500
        assert Impairments(rate=1_000_000, queue_bytes=3000).room == 3000


class TestAGoodLink:
    def test_everything_arrives_at_once_and_in_order(self) -> None:
        link = Link()
        assert passed(link, numbered(3), until=0.002) == numbered(3)
        assert link.next_at is None
        figures = link.figures()
        assert (figures.entered, figures.entered_bytes, figures.delivered, figures.delivered_bytes) == (3, 3, 3, 3)

    def test_figures_are_a_copy(self) -> None:
        link = Link()
        before = link.figures()
        passed(link, numbered(1))
        assert before.entered == 0


class TestRate:
    def test_a_datagram_takes_its_size_and_those_behind_it_wait(self) -> None:
        link = Link(Impairments(rate=1_000_000))
        link.push(EIGHT_KBIT, 0.0)
        link.push(EIGHT_KBIT, 0.0)
        assert link.next_at == 0.008
        assert link.pop(0.0079) == []
        assert len(link.pop(0.008)) == 1
        assert (link.next_at, link.waiting) == (0.016, 1000)
        assert len(link.pop(0.016)) == 1
        assert link.next_at is None

    def test_after_a_pause_it_begins_anew(self) -> None:
        link = Link(Impairments(rate=1_000_000))
        link.push(EIGHT_KBIT, 0.0)
        link.push(EIGHT_KBIT, 1.0)
        assert link.next_at == 0.008
        assert len(link.pop(1.0)) == 1
        assert link.next_at == 1.008

    def test_the_queue_drops_what_comes_when_it_is_full(self) -> None:
        link = Link(Impairments(rate=1_000_000, queue=0.016))
        for _ in range(5):
            link.push(EIGHT_KBIT, 0.0)
        assert (link.figures().dropped, link.figures().most_waiting) == (3, 2000)
        assert len(link.pop(1.0)) == 2

    def test_one_may_always_go_however_small_the_queue_is(self) -> None:
        link = Link(Impairments(rate=1_000_000, queue_bytes=0))
        link.push(EIGHT_KBIT, 0.0)
        link.push(EIGHT_KBIT, 0.0)
        assert len(link.pop(1.0)) == 1


class TestDelay:
    def test_it_comes_behind_the_bottleneck(self) -> None:
        link = Link(Impairments(rate=1_000_000, delay=0.1))
        link.push(EIGHT_KBIT, 0.0)
        link.pop(0.05)
        assert link.next_at == pytest.approx(0.108)
        assert len(link.pop(0.1081)) == 1

    def test_the_next_moment_is_the_earlier_one(self) -> None:
        link = Link(Impairments(rate=1_000_000, delay=0.1))
        link.push(EIGHT_KBIT, 0.0)
        link.push(EIGHT_KBIT, 0.097)
        assert link.next_at == pytest.approx(0.105)
        link.pop(0.1051)
        assert link.next_at == pytest.approx(0.108)

    def test_jitter_delays_and_never_reorders(self) -> None:
        link = Link(Impairments(delay=0.01, jitter=0.05))
        arrivals = []
        for number, datagram in enumerate(numbered(200)):
            link.push(datagram, number * 0.001)
        while (due := link.next_at) is not None:
            arrivals += [(due, datagram) for datagram in link.pop(due)]
        assert [datagram for _, datagram in arrivals] == numbered(200)
        delays = [at - number * 0.001 for number, (at, _) in enumerate(arrivals)]
        assert min(delays) >= 0.01
        assert max(delays) <= 0.06 + 1e-9
        assert max(delays) - min(delays) > 0.02

    def test_a_shorter_delay_does_not_overtake(self) -> None:
        link = Link(Impairments(delay=0.1))
        link.push(b"slow", 0.0)
        link.change(Impairments(), 0.01)
        link.push(b"fast", 0.01)
        assert link.pop(0.05) == []
        assert link.pop(0.1) == [b"slow", b"fast"]


class TestLoss:
    def test_its_share_is_lost(self) -> None:
        link = Link(Impairments(loss=0.05), seed=1)
        arrived = passed(link, numbered(10_000))
        assert 400 < link.figures().lost < 600
        assert len(arrived) == 10_000 - link.figures().lost

    @pytest.mark.parametrize("burst", [1, 4, 10])
    def test_it_comes_in_bursts_and_stays_the_same_share(self, burst: float) -> None:
        link = Link(Impairments(loss=0.1, burst=burst), seed=1)
        arrived = set(passed(link, numbered(40_000)))
        lost = [datagram not in arrived for datagram in numbered(40_000)]
        runs = [sum(1 for _ in group) for is_lost, group in itertools.groupby(lost) if is_lost]
        assert sum(runs) / 40_000 == pytest.approx(0.1, rel=0.15)
        assert sum(runs) / len(runs) == pytest.approx(burst, rel=0.15)

    @pytest.mark.parametrize(("loss", "left"), [(0.0, 50), (1.0, 0)])
    @pytest.mark.parametrize("burst", [None, 5])
    def test_nothing_and_everything(self, loss: float, left: int, burst: float | None) -> None:
        assert len(passed(Link(Impairments(loss=loss, burst=burst)), numbered(50))) == left

    def test_so_many_in_a_row_on_demand(self) -> None:
        link = Link()
        link.push(b"before", 0.0)
        link.lose_next(2)
        assert passed(link, numbered(4)) == [b"before", b"2", b"3"]
        assert link.figures().lost == 2


class TestOrder:
    def test_held_back_datagram_is_overtaken(self) -> None:
        link = Link(Impairments(reorder=1, reorder_by=0.02))
        link.push(b"first", 0.0)
        link.change(Impairments(), 0.001)
        link.push(b"second", 0.001)
        assert link.pop(1.0) == [b"second", b"first"]
        assert link.figures().held_back == 1

    def test_copies_come_together(self) -> None:
        link = Link(Impairments(duplicate=1))
        assert passed(link, numbered(2)) == [b"0", b"0", b"1", b"1"]
        assert (link.figures().duplicated, link.figures().delivered) == (2, 4)

    def test_the_same_seed_does_the_same(self) -> None:
        bad = Impairments(loss=0.2, jitter=0.03, reorder=0.2, duplicate=0.2)
        assert passed(Link(bad, seed=3), numbered(300)) == passed(Link(bad, seed=3), numbered(300))
        assert passed(Link(bad, seed=3), numbered(300)) != passed(Link(bad, seed=4), numbered(300))


class TestChange:
    def test_waiting_datagrams_go_on_at_the_new_rate(self) -> None:
        link = Link(Impairments(rate=1_000_000))
        link.push(EIGHT_KBIT, 0.0)
        link.push(EIGHT_KBIT, 0.0)
        link.change(Impairments(rate=500_000), 0.004)
        assert link.next_at == 0.012
        assert len(link.pop(0.012)) == 1
        assert link.next_at == 0.028

    def test_without_a_bottleneck_all_of_it_goes(self) -> None:
        link = Link(Impairments(rate=1_000_000))
        for _ in range(3):
            link.push(EIGHT_KBIT, 0.0)
        link.change(Impairments(), 0.004)
        assert link.impairments == Impairments()
        assert len(link.pop(0.004)) == 3

    def test_nothing_waits_and_nothing_happens(self) -> None:
        link = Link(Impairments(rate=1_000_000))
        link.change(Impairments(rate=500_000), 5.0)
        assert link.next_at is None


def test_travelling_datagrams_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "FLIGHT_LIMIT", 5)
    link = Link(Impairments(delay=10))
    assert len(passed(link, numbered(8))) == 5
    assert link.figures().dropped == 3


shares = st.floats(0, 1)


@given(
    st.builds(
        Impairments,
        rate=st.none() | st.floats(1000, 1e8),
        queue=st.floats(0, 0.5),
        queue_bytes=st.none() | st.integers(0, 10_000),
        delay=st.floats(0, 1),
        jitter=st.floats(0, 1),
        loss=shares,
        burst=st.none() | st.floats(1, 20),
        reorder=shares,
        reorder_by=st.floats(0, 1),
        duplicate=shares,
    ),
    st.lists(st.tuples(st.floats(0, 0.1), st.binary(max_size=20)), max_size=40),
)
def test_every_datagram_is_accounted_for(impairments: Impairments, sent: list[tuple[float, bytes]]) -> None:
    link = Link(impairments)
    now = 0.0
    arrived: list[bytes] = []
    for pause, datagram in sent:
        now += pause
        link.push(datagram, now)
        arrived += link.pop(now)
    steps = 0
    while (due := link.next_at) is not None:
        arrived += link.pop(due)
        steps += 1
        assert steps <= 4 * len(sent)
    figures = link.figures()
    assert figures.delivered == len(arrived) == figures.entered - figures.dropped - figures.lost + figures.duplicated
    assert figures.delivered_bytes == sum(map(len, arrived))
    assert set(arrived) <= {datagram for _, datagram in sent}
    assert link.waiting == 0
    assert all(value >= 0 for value in asdict(figures).values())
