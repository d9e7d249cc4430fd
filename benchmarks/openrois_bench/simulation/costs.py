"""What each kind of work cost in the phases of a campaign, and how much of each a phase had. Pure."""

from collections.abc import Mapping, Sequence
from typing import Final

from openrois_bench.simulation.paper import Work
from openrois_bench.simulation.phase import Phase

__all__ = ["NAMES", "amount", "costs", "memory_costs", "phases_by_name"]

NAMES: Final = {
    "attach": "attached",
    "session": "sessions",
    "leave": "returns",
    "query": "queries",
    "pipelined_query": "pipelined queries",
    "command": "commands",
    "subscription": "subscriptions",
    "event": "events",
    "delivery": "deliveries",
    "burst_event": "burst events",
    "burst_delivery": "burst deliveries",
    "stream": "streams",
    "sign": "signs of life",
    "change": "changes",
    "hop": "hops",
    "fault": "fault checks",
}
"""The count of each kind of work."""


def phases_by_name(phases: Sequence[Phase]) -> dict[str, Phase]:
    """Return phases by their names."""
    return {phase.name: phase for phase in phases}


def amount(counts: Mapping[str, int]) -> Work:
    """Return the work that was done."""
    return Work(**{name: float(counts.get(count, 0)) for name, count in NAMES.items()})


def costs(phases: Sequence[Phase]) -> Work:
    """Return the processor seconds of one of each kind.

    What gateways take while idle is subtracted. A phase may have work of more than one kind: what the others cost is
    known by then, and subtracted, too.
    """
    named = phases_by_name(phases)
    idle = named["idle"].cpu / named["idle"].seconds

    def net(name: str) -> float:
        return named[name].cpu - idle * named[name].seconds

    def count(what: str, name: str) -> int:
        return named[name].counts.get(what, 0)

    def each(what: str, name: str, others: float = 0.0) -> float:
        number = count(what, name)
        return max(net(name) - others, 0.0) / number if number else 0.0

    attach, session = each("attached", "attach"), each("sessions", "enter")

    def solved(events: str, deliveries: str, phases: str) -> tuple[float, float]:
        names = f"{phases} to one", f"{phases} to many"
        return _solved(*((count(events, name), count(deliveries, name), net(name)) for name in names))

    event, delivery = solved("events", "deliveries", "events")
    burst_event, burst_delivery = solved("burst events", "burst deliveries", "bursts")
    change = each("changes", "restart", count("attached", "restart") * attach)
    at_a_loss = count("attached", "loss") * attach + count("changes", "loss") * change
    hops = sum(phase.counts.get("hops", 0) for phase in phases)
    return Work(
        attach=attach,
        session=session,
        leave=each("returns", "return", count("sessions", "return") * session),
        query=each("queries", "query"),
        pipelined_query=each("pipelined queries", "query together"),
        command=each("commands", "command"),
        subscription=each("subscriptions", "subscription"),
        event=event,
        delivery=delivery,
        burst_event=burst_event,
        burst_delivery=burst_delivery,
        stream=each("streams", "stream"),
        sign=each("signs of life", "move"),
        change=change,
        hop=sum(phase.spent.hops for phase in phases) / hops if hops else 0.0,
        fault=each("fault checks", "loss", at_a_loss),
    )


def _solved(one: tuple[int, int, float], many: tuple[int, int, float]) -> tuple[float, float]:
    """Return what an event and a delivery cost, from two phases with another number of deliveries for each event."""
    (events, deliveries, seconds), (more_events, more_deliveries, more_seconds) = one, many
    determinant = events * more_deliveries - more_events * deliveries
    if not determinant:
        # One application for each body: nothing tells them apart.
        return 0.0, seconds / deliveries
    event = (seconds * more_deliveries - more_seconds * deliveries) / determinant
    delivery = (events * more_seconds - more_events * seconds) / determinant
    return max(event, 0.0), max(delivery, 0.0)


def memory_costs(phases: Sequence[Phase]) -> tuple[float, float, float]:
    """Return the bytes of a body, of a session, and of an event that a session keeps for its details."""
    named = phases_by_name(phases)
    kept = named["events to many"]
    return (
        _growth(named["empty"], named["attach"]) / named["attach"].counts["attached"],
        _growth(named["attach"], named["enter"]) / named["enter"].counts["sessions"],
        _growth(named["subscribe to many"], kept) / kept.counts["deliveries"],
    )


def _growth(before: Phase, after: Phase) -> int:
    return max(after.resident - before.resident, 0)
