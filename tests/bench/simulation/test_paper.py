"""The formulas of the paper model."""

from dataclasses import replace

import pytest
from openrois_bench.simulation.mix import at_work
from openrois_bench.simulation.paper import (
    CONNECTIONS,
    MEBIBYTE,
    MEDIA,
    MESSAGES,
    TOGETHER,
    Costs,
    Load,
    Wire,
    Work,
    cpu,
    gateways,
    memory,
    over_sockets,
    streams,
)

COSTS = Costs(Work(attach=0.002, query=0.0001, delivery=0.00001), body=50_000, session=60_000, detail=500, connection=0)


def test_processor_time_is_the_sum_over_all_kinds() -> None:
    assert cpu(COSTS.work, Work(attach=10, query=1000, delivery=5000, stream=7)) == pytest.approx(0.02 + 0.1 + 0.05)


def test_memory_counts_what_sessions_keep() -> None:
    load = Load(bodies=10, applications=100, a_second=Work(), details=20)
    assert memory(COSTS, load) == 10 * 50_000 + 100 * (60_000 + 20 * 500)
    with_sockets = replace(COSTS, connection=1000)
    assert memory(with_sockets, load) == memory(COSTS, load) + 110 * 1000


@pytest.mark.parametrize(
    ("queries", "applications", "needed"),
    [
        (0, 0, 1),
        (5_000, 0, 1),
        (5_001, 0, 2),
        # More memory than processor time: 60,000,000 bytes are 57.2 MiB.
        (5_000, 1_000, 2),
    ],
)
def test_gateways_are_as_many_as_processor_and_memory_need(queries: int, applications: int, needed: int) -> None:
    load = Load(bodies=0, applications=applications, a_second=Work(query=queries))
    assert gateways(COSTS, load, busy=0.5, bytes_each=50 * MEBIBYTE) == needed


def test_sockets_add_messages_and_connections() -> None:
    each = over_sockets(COSTS.work, Wire(message=1.0, together=0.5, connection=100.0)).parts()
    without = COSTS.work.parts()
    for name, messages in MESSAGES.parts().items():
        wire = 0.5 if name in TOGETHER else 1.0
        assert each[name] == pytest.approx(without[name] + messages * wire + 100 * CONNECTIONS.parts()[name])
    assert each["query"] == pytest.approx(4.0001)


def test_a_load_at_work_is_what_each_does_now_and_then() -> None:
    load = at_work(bodies=3600, applications=36_000, gateways=10, seeing_all=0.01)
    assert (load.bodies, load.applications) == (3600, 36_000)
    a_second = load.a_second
    assert a_second.attach == pytest.approx(1)
    assert a_second.query == pytest.approx(3600)
    assert (a_second.event, a_second.delivery) == pytest.approx((3 * 3600, 3 * 36_000))
    # A command of 3 s each minute, with ten signs of life a second.
    assert a_second.sign == pytest.approx(36_000 / 60 * 30)
    # Ten applications of its own and 36 that see all bodies of the gateway learn that one has gone, and is back.
    assert a_second.change == pytest.approx(2 * (10 + 36))
    assert a_second.fault == pytest.approx(0.01 * 3600)


def test_streams_of_ten_thousand_avatars() -> None:
    needed = streams(MEDIA, avatars=10_000, viewers=100_000, uplink=20e6)
    assert needed.egress == pytest.approx(250e9)
    assert needed.relayed == pytest.approx(37.5e9)
    assert needed.cores == pytest.approx(370)
    assert needed.uplink == pytest.approx(25e6)
    assert needed.needs_sfu


@pytest.mark.parametrize(
    ("viewers", "uplink", "needed"), [(8, 20e6, False), (9, 20e6, True), (200, 1e9, False), (201, 1e9, True)]
)
def test_an_sfu_is_needed_for_more_viewers_than_uplink_or_loop_carry(viewers: int, uplink: float, needed: bool) -> None:
    assert streams(MEDIA, avatars=1, viewers=viewers, uplink=uplink).needs_sfu is needed
