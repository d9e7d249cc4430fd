"""The paper model's tables: what one of each kind costs, what a load needs, and how far off the formulas are."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from openrois_bench.measuring.figures import MICROSECONDS
from openrois_bench.simulation.mix import at_work
from openrois_bench.simulation.paper import (
    CONNECTIONS,
    MEBIBYTE,
    MEDIA,
    MESSAGES,
    TOGETHER,
    Costs,
    Wire,
    Work,
    cpu,
    gateways,
    memory,
    over_sockets,
    streams,
)

__all__ = [
    "scale_compared",
    "scale_costs",
    "scale_needs",
    "scale_others",
    "scale_saturation",
    "scale_streams",
    "scale_wire",
]

RESULTS: Final = Path(__file__).parents[2] / "benchmarks/results"

BUSY: Final = 0.5
"""Share of a processor that a gateway may take in the table of needs."""

KEPT: Final = 200
"""Events that a session keeps in the table of needs."""

_ALONE: Final = ("attach", "session", "query", "pipelined_query", "command", "subscription", "stream", "sign", "change")
"""Kinds that were measured one by one; an event comes with its deliveries."""

_WAKES: Final = Work(command=5, event=1, sign=1, change=1)
"""Messages of one of a kind that come at times of their own: a gateway that does little wakes for each."""

FLEETS: Final = ((100, 1_000), (1_000, 10_000), (10_000, 100_000))
UPLINK: Final = 20e6
"""Bits a second that leave an avatar in the table of streams."""


def found(name: str) -> dict[str, Any]:
    """Return a result that is kept."""
    told: dict[str, Any] = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return told


def work(result: Mapping[str, Any]) -> Work:
    """Return the seconds of one of each kind."""
    return Work(**{name: cost / MICROSECONDS for name, cost in result["cost_us"].items()})


def wire() -> Wire:
    """Return what sockets add: to a message while all are at work, to one of several together, and to a connection."""
    small, real = found("simulation_small"), found("simulation_real")
    without, measured = work(small).parts(), work(real).parts()
    amount, connections = _at_work(real), CONNECTIONS.parts()
    message = (real["loads"]["rush"]["simulated_s"] - cpu(work(small), amount)) / cpu(MESSAGES, amount)
    # One of each kind, and as many deliveries as an event has there.
    mixed = {name: 1 if name != "burst_delivery" else _shared(real) for name in TOGETHER}
    together = sum(number * (measured[name] - without[name]) for name, number in mixed.items())
    opened = [name for name, number in connections.items() if number]
    more = [measured[name] - without[name] - MESSAGES.parts()[name] * message for name in opened]
    return Wire(message, together / cpu(MESSAGES, Work(**mixed)), sum(more) / len(more))


def _shared(result: Mapping[str, Any]) -> int:
    return int(result["plan"]["applications"] // result["plan"]["bodies"])


def wake() -> float:
    """Return the seconds that a message takes more for which a gateway wakes: the mean over those not of commands."""
    without = over_sockets(work(found("simulation_small")), wire()).parts()
    measured = work(found("simulation_real")).parts()
    named = ("event", "sign", "change")
    return max(sum(measured[name] - without[name] for name in named) / len(named), 0.0)


def connection_kib() -> float:
    """Return the memory of a connection: the mean of what bodies and sessions take more with sockets."""
    without, real = found("simulation_small")["memory"], found("simulation_real")["memory"]
    return sum(float(real[name] - without[name]) for name in ("body_kib", "session_kib")) / 2


def scale_costs() -> list[str]:
    """Return what one of each kind costs a gateway."""
    large, small = found("simulation")["cost_us"], found("simulation_small")["cost_us"]
    sockets, added = over_sockets(work(found("simulation")), wire()).parts(), MESSAGES.parts()
    rows = [
        (f"`{name}`", f"{small[name]:.1f}", f"{large[name]:.1f}", f"{added[name]:.0f}", _us(sockets[name]))
        for name in large
    ]
    heads = ("kind", _of(found("simulation_small")), _of(found("simulation")), "messages", "with sockets")
    return _table(heads, rows)


def scale_wire() -> list[str]:
    """Return what sockets add."""
    sockets = wire()
    return [
        f"A message that is read or written adds {_us(sockets.message)} us, and one of several that come together "
        f"{_us(sockets.together)} us. A connection adds {sockets.connection * 1000:.1f} ms "
        f"and {connection_kib():.0f} KiB. Where a gateway does little, a message that it wakes for takes "
        f"{_us(wake())} us more.",
    ]


def scale_saturation() -> list[str]:
    """Return where the simulated gateways saturate."""
    result = found("simulation")
    plan, rush, memories = result["plan"], result["loads"]["rush"], result["memory"]
    each = plan["applications"] / plan["gateways"]
    rows = [
        (
            "the loop's processor, of the busiest gateway",
            f"{rush['busiest']:.0%} at {each:,.0f} applications",
            f"{each / rush['busiest']:,.0f} applications at work",
        ),
        (
            "memory of sessions",
            f"{memories['session_kib']:.0f} KiB each, {each * memories['session_kib'] / 1024:,.0f} MiB",
            f"{MEBIBYTE / memories['session_kib']:,.0f} sessions a GiB",
        ),
        ("memory of bodies", f"{memories['body_kib']:.0f} KiB each", f"{MEBIBYTE / memories['body_kib']:,.0f} a GiB"),
        (
            "memory of events for whose details a session may ask",
            f"{memories['kept_event_b']} B each",
            f"1,024 each session: {memories['kept_event_b'] / 1024 * each:,.0f} MiB",
        ),
        (
            "open files",
            f"{result['descriptors']['most_applications']:,} and {result['descriptors']['most_adapters']:,}",
            "`most_applications`, `most_adapters`",
        ),
        (
            "events to applications",
            f"{rush['deliveries_a_second'] / plan['gateways']:,.0f} a second",
            f"{MICROSECONDS / result['cost_us']['delivery']:,.0f} a second, and nothing else",
        ),
        ("claims in the store", f"{rush['claims_a_second']:.1f} a second, of all gateways", "not simulated"),
        ("the loop, when an adapter is lost", f"stands still for {result['blocked_by_a_loss_ms']:,.0f} ms", ""),
    ]
    table = _table(("resource of one gateway", "while all are at work", "it saturates at"), rows)
    hours, minutes = result["virtual_seconds"] / 3600, result["cpu_seconds"] / 60
    took = (
        f"{plan['bodies']:,} bodies, {plan['applications']:,} applications and {plan['gateways']} gateways: "
        f"{hours:.1f} virtual hours took {minutes:.0f} minutes of a processor, and at most "
        f"{memories['most_mib'] / 1024:.1f} GiB with all peers. In the busiest minute of the day one gateway took "
        f"{result['day_peak']:.1%} of a processor."
    )
    return [*table, "", took]


def scale_needs() -> list[str]:
    """Return what fleets at work need, by the formulas."""
    result = found("simulation")
    each = over_sockets(work(result), wire())
    kept = result["memory"]
    bytes_each = kept["body_kib"] * 1024, kept["session_kib"] * 1024, kept["kept_event_b"], connection_kib() * 1024
    costs = Costs(each, *bytes_each)
    rows = []
    for bodies, applications in FLEETS:
        number = 1
        # Sessions of the same gateway learn of a body that comes or goes: their number depends on that of gateways.
        while (needed := _needed(costs, bodies, applications, number)) > number:
            number = needed
        load = at_work(bodies, applications, number)
        rows.append(
            (
                f"{bodies:,}",
                f"{applications:,}",
                f"{cpu(each, load.a_second):.1f}",
                f"{(memory(costs, load) + applications * KEPT * costs.detail) / MEBIBYTE / 1024:.1f}",
                f"{number:,}",
            )
        )
    return _table(("bodies", "applications at work", "processors", "GiB", f"gateways, each {BUSY:.0%} busy"), rows)


def _needed(costs: Costs, bodies: int, applications: int, number: int) -> int:
    load = at_work(bodies, applications, number)
    return gateways(costs, load, BUSY, 4 * 1024 * MEBIBYTE)


def scale_streams() -> list[str]:
    """Return what viewers of streams need, by the formulas."""
    rows = []
    for avatars, viewers in ((1, 8), (1, 200), (10_000, 100_000)):
        needed = streams(MEDIA, avatars, viewers, UPLINK)
        rows.append(
            (
                f"{avatars:,}",
                f"{viewers:,}",
                f"{needed.cores:,.2f}",
                f"{needed.egress / 1e9:,.2f}",
                f"{needed.relayed / 1e9:,.3f}",
                f"{needed.uplink / 1e6:,.0f}",
                "yes" if needed.needs_sfu else "no",
            )
        )
    heads = ("avatars", "viewers", "processors of senders", "egress, Gbit/s", "by TURN", "uplink of one, Mbit/s", "SFU")
    return _table(heads, rows)


def scale_compared() -> list[str]:
    """Return how far the formulas are from the simulator, and from a gateway over sockets."""
    small, large, real = (found(name) for name in ("simulation_small", "simulation", "simulation_real"))
    rows = []
    for result in (small, large):
        for name, load in result["loads"].items():
            # What begins in the few seconds of a rush has not all ended in them: it goes by its rates.
            seconds = cpu(work(result), _at_work(result)) if name == "rush" else load["formula_s"]
            took = load["simulated_s"]
            rows.append((f"{name}, {_of(result)}", f"{took:.2f} s", f"{seconds:.2f} s", f"{seconds / took:.2f}"))
    tables = _table(("simulator, all kinds together", "simulated", "by the formulas", "ratio"), rows)
    measured, wakes = work(real), _WAKES.parts()
    at_once = over_sockets(work(small), wire()).parts()
    expected = Work(**{name: cost + wakes[name] * wake() for name, cost in at_once.items()})
    kinds = [_row(f"`{name}`", Work(**{name: 1.0}), measured, expected) for name in _ALONE]
    kinds += [
        row
        for number in (1, _shared(real))
        for row in (
            _row(f"`event` and {number} x `delivery`", Work(event=1.0, delivery=number), measured, expected),
            _row(f"the same in bursts, {number}", Work(burst_event=1.0, burst_delivery=number), measured, expected),
        )
    ]
    return [
        *tables,
        "",
        *_table((f"one gateway over sockets, {_of(real)}", "measured, us", "by the formulas, us", "ratio"), kinds),
    ]


def scale_others() -> list[str]:
    """Return what other programs measured, beside the formulas."""
    expected = over_sockets(work(found("simulation_small")), wire())
    rpc, events, fleet = (found(f"scale_{name}") for name in ("rpc", "events", "fleet"))
    many, heard = events["many"]["gateway_us"], events["clients"]
    delivery = cpu(expected, Work(burst_event=1.0 / heard, burst_delivery=1.0)) * MICROSECONDS
    rows = [
        _other(
            f"`openrois bench rpc --auth`: a query of {rpc['clients'] * rpc['depth']} at a time",
            *(rpc["pipelined"]["gateway_us"], expected.pipelined_query * MICROSECONDS, "us"),
        ),
        _other(f"`openrois bench events --auth`: a delivery in bursts to {heard} applications", many, delivery, "us"),
    ]
    for each in fleet["fleet"]:
        bodies = f"`python -m openrois_bench.gateway.fleet`: at {each['bodies']:,} bodies"
        memory_each = found("simulation_small")["memory"]["body_kib"] + connection_kib()
        # Of which half are attached before applications that see others: one look for garbage is seldom in both halves.
        attach_ms = (each["attach_ms"] + each["attach_with_scopes_ms"]) / 2
        rows += [
            _other(f"{bodies}, each of the next 200", attach_ms, expected.attach * 1000, "ms"),
            _other(f"{bodies}, the memory of one", each["memory_kib_each"], memory_each, "KiB"),
        ]
    return _table(("program", "measured", "by the formulas", "ratio"), rows)


def _other(name: str, measured: float, expected: float, unit: str) -> tuple[str, ...]:
    return name, f"{measured:,.1f} {unit}", f"{expected:,.1f} {unit}", f"{expected / measured:.2f}"


def _at_work(result: Mapping[str, Any]) -> Work:
    """Return what there was in the rush of a result, by the rates of those at work."""
    plan = result["plan"]
    load = at_work(plan["bodies"], plan["applications"], plan["gateways"], plan["seeing_all"])
    more = dict.fromkeys(("event", "delivery"), plan["rate"])
    return Work(**{name: each * plan["rush"] * more.get(name, 1) for name, each in load.a_second.parts().items()})


def _row(name: str, amount: Work, measured: Work, expected: Work) -> tuple[str, ...]:
    found_us, formula_us = cpu(measured, amount), cpu(expected, amount)
    return name, _us(found_us), _us(formula_us), f"{formula_us / found_us:.2f}"


def _of(result: Mapping[str, Any]) -> str:
    return f"{result['plan']['bodies']:,} / {result['plan']['applications']:,}"


def _us(seconds: float) -> str:
    return f"{seconds * MICROSECONDS:,.1f}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]
