"""What each kind of work cost, from phases whose costs are known."""

from collections.abc import Mapping

import pytest
from openrois_bench.simulation.costs import NAMES, amount, costs, memory_costs
from openrois_bench.simulation.paper import Work, cpu
from openrois_bench.simulation.phase import Phase, Spent

TRUE = Work(
    attach=2e-3,
    session=1e-3,
    leave=3e-4,
    query=2e-4,
    pipelined_query=1e-4,
    command=9e-4,
    subscription=4e-4,
    event=7e-5,
    delivery=2e-5,
    burst_event=4e-5,
    burst_delivery=1e-5,
    stream=2e-3,
    sign=3e-5,
    change=5e-5,
    hop=1e-5,
    fault=9e-6,
)
IDLE = 0.01
COUNTS: Mapping[str, Mapping[str, int]] = {
    "empty": {},
    "attach": {"attached": 100},
    "enter": {"sessions": 1000},
    "idle": {},
    "query": {"queries": 1000, "hops": 50},
    "query together": {"pipelined queries": 2000},
    "command": {"commands": 100},
    "subscription": {"subscriptions": 1000},
    "move": {"signs of life": 10_000},
    "events to one": {"events": 6000, "deliveries": 6000},
    "subscribe to many": {"subscriptions": 1000, "events": 3000, "deliveries": 15_000},
    "events to many": {"events": 6000, "deliveries": 60_000},
    "bursts to one": {"burst events": 3200, "burst deliveries": 3200},
    "bursts to many": {"burst events": 3200, "burst deliveries": 32_000},
    "stream": {"streams": 100},
    "return": {"returns": 1000, "sessions": 1000},
    "restart": {"attached": 20, "changes": 400},
    "loss": {"attached": 20, "changes": 400, "fault checks": 340_000},
}


def phase(name: str, counts: Mapping[str, int], resident: int = 0, idle: float = IDLE) -> Phase:
    work = amount(counts).parts()
    hops = work["hop"] * TRUE.hop
    seconds = cpu(TRUE, Work(**{**work, "hop": 0.0})) + idle * 10
    return Phase(name, 10.0, counts, Spent((seconds + hops,), 0.0, seconds, hops, seconds), resident)


def test_costs_are_found_again() -> None:
    found = costs([phase(name, counts) for name, counts in COUNTS.items()])
    assert found.parts() == pytest.approx(TRUE.parts())
    assert set(NAMES) == set(TRUE.parts())


def test_one_application_of_each_body_does_not_tell_events_from_deliveries() -> None:
    alike = {**COUNTS, "events to many": COUNTS["events to one"]}
    found = costs([phase(name, counts) for name, counts in alike.items()])
    assert found.event == 0
    assert found.delivery == pytest.approx(TRUE.event + TRUE.delivery)


def test_work_that_did_not_happen_costs_nothing() -> None:
    without = {**COUNTS, "query": {}, "query together": {}, "stream": {}}
    found = costs([phase(name, counts) for name, counts in without.items()])
    assert (found.query, found.pipelined_query, found.stream, found.hop) == (0, 0, 0, 0)


def test_memory_is_what_came_with_bodies_sessions_and_events() -> None:
    resident = {"attach": 5_000, "enter": 65_000, "subscribe to many": 65_000, "events to many": 30_065_000}
    phases = [phase(name, counts, resident.get(name, 0)) for name, counts in COUNTS.items()]
    assert memory_costs(phases) == (50.0, 60.0, 500.0)


def test_the_busiest_gateway_counts() -> None:
    two = Phase("rush", 10.0, {}, Spent((1.0, 3.0), 2.0, 1.5, 0.5, 9.0), 0)
    assert two.cpu == 3.5
    assert two.busiest == pytest.approx(0.3)
    assert Phase("rush", 0.0, {}, Spent((1.0,), 1.0, 0.0, 0.0, 1.0), 0).busiest == 0
