"""The figures of a campaign: what each kind of work costs, where a gateway saturates, and what the formulas say."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Final

from openrois.gateway.connection_limits import MAX_ADAPTERS, MAX_APPLICATIONS
from openrois_bench.measuring.figures import MICROSECONDS
from openrois_bench.measuring.table import table
from openrois_bench.simulation.costs import amount, costs, memory_costs, phases_by_name
from openrois_bench.simulation.paper import MEBIBYTE, Work, cpu
from openrois_bench.simulation.phase import Phase
from openrois_bench.simulation.world import Plan

__all__ = ["figures", "printed"]

_KIBIBYTE: Final = 1024
_COMPARED: Final = ("rush", "day")
"""Phases in which all kinds of work come together: what the formulas say of them is compared."""


def figures(plan: Plan, phases: Sequence[Phase], peak: float) -> dict[str, Any]:
    """Return what was found, as JSON values.

    Args:
        plan: what was simulated.
        phases: what each phase took.
        peak: the greatest share of a processor of one gateway in the long day.
    """
    named, each = phases_by_name(phases), costs(phases)
    body, session, detail = memory_costs(phases)
    connections = _connections(plan)
    return {
        "plan": asdict(plan),
        "cost_us": {name: round(cost * MICROSECONDS, 2) for name, cost in each.parts().items()},
        "idle_share": round(named["idle"].busiest, 4),
        "memory": {
            "body_kib": round(body / _KIBIBYTE, 1),
            "session_kib": round(session / _KIBIBYTE, 1),
            "kept_event_b": round(detail),
            "most_mib": max(phase.resident for phase in phases) // MEBIBYTE,
        },
        "messages": dict(sum((Counter(phase.counts) for phase in phases), Counter())),
        "cpu_seconds": round(sum(phase.spent.total for phase in phases), 1),
        "virtual_seconds": round(sum(phase.seconds for phase in phases)),
        "loads": {name: _load(named[name], each) for name in _COMPARED if name in named},
        "day_peak": round(peak, 6),
        "descriptors": {"most_applications": connections, "most_adapters": -(-plan.bodies // plan.gateways)},
        "blocked_by_a_loss_ms": round(each.fault * plan.applications / plan.gateways * 1000, 1),
    }


def _connections(plan: Plan) -> int:
    """Return the applications of one gateway: those that dial it."""
    return -(-plan.applications // plan.gateways)


def _load(phase: Phase, each: Work) -> dict[str, Any]:
    owned = cpu(each, Work(**{**amount(phase.counts).parts(), "hop": 0.0}))
    return {
        "busiest": round(phase.busiest, 6),
        "mean": round(sum(phase.spent.gateways) / len(phase.spent.gateways) / phase.seconds, 6),
        "deliveries_a_second": round(phase.counts.get("deliveries", 0) / phase.seconds, 1),
        "claims_a_second": round(phase.counts.get("attached", 0) / phase.seconds, 2),
        "simulated_s": round(phase.cpu, 3),
        "formula_s": round(owned, 3),
        "ratio": round(owned / phase.cpu, 2) if phase.cpu else None,
    }


def printed(found: Mapping[str, Any]) -> str:
    """Return the figures as tables."""
    return "\n\n".join((_costs(found), _saturation(found), _comparison(found)))


def _costs(found: Mapping[str, Any]) -> str:
    rows = [
        (name, f"{cost:.1f}", f"{MICROSECONDS / cost:.0f}" if cost else "-") for name, cost in found["cost_us"].items()
    ]
    return table(("one of a kind", "CPU us of a gateway", "a second saturate one gateway"), rows)


def _saturation(found: Mapping[str, Any]) -> str:
    plan, memory, descriptors = found["plan"], found["memory"], found["descriptors"]
    rows: list[tuple[str, str, str]] = []
    if rush := found["loads"].get("rush"):
        most = plan["applications"] / plan["gateways"] / rush["busiest"]
        rows += [
            (
                "loop of the busiest gateway",
                f"{rush['busiest']:.1%} of a processor",
                f"{most:.0f} applications at work",
            ),
            ("loop of a gateway, mean", f"{rush['mean']:.1%}", ""),
            ("events to applications", f"{rush['deliveries_a_second']:.0f} a second", ""),
            ("claims in the store", f"{rush['claims_a_second']:.1f} a second", ""),
        ]
    each = (
        (plan["bodies"] * memory["body_kib"] + plan["applications"] * memory["session_kib"])
        / plan["gateways"]
        / _KIBIBYTE
    )
    per_gibibyte = MEBIBYTE / memory["session_kib"] if memory["session_kib"] else 0
    apps, bodies = descriptors["most_applications"], descriptors["most_adapters"]
    rows += [
        ("memory of a gateway, at rest", f"{each:.0f} MiB", f"{per_gibibyte:.0f} sessions a GiB"),
        ("memory of an event that a session keeps", f"{memory['kept_event_b']} B", ""),
        ("open files for applications", f"{apps}", f"most_applications, {MAX_APPLICATIONS} unless set"),
        ("open files for adapters", f"{bodies}", f"most_adapters, {MAX_ADAPTERS} unless set"),
        ("loop while an adapter is lost", f"blocked for {found['blocked_by_a_loss_ms']} ms", ""),
    ]
    return table(("each gateway has", "while all are at work", "it saturates at"), rows)


def _comparison(found: Mapping[str, Any]) -> str:
    rows = [
        (name, f"{load['simulated_s']}", f"{load['formula_s']}", f"{load['ratio']}")
        for name, load in found["loads"].items()
    ]
    more = (
        f"{found['virtual_seconds']} virtual seconds took {found['cpu_seconds']} s of a processor and at most "
        f"{found['memory']['most_mib']} MiB; busiest minute of the day: {found['day_peak']:.3%} of a gateway"
    )
    return f"{table(('all kinds together', 'simulated, s', 'by the formulas, s', 'ratio'), rows)}\n\n{more}"
