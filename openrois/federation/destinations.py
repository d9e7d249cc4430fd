"""Which engine a request of an application is about: by the names and ids in its params. Pure."""

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any, Final

from openrois.interfaces.overload_rules import is_stop
from openrois.types.references import engine_of

__all__ = ["OF_ENGINE", "command_ids", "engine_named", "engines_commanded", "only_stops"]

OF_ENGINE: Final[Mapping[str, str]] = {
    **dict.fromkeys(
        (
            "rois.command.bind",
            "rois.command.release",
            "rois.command.get_parameter",
            "rois.command.set_parameter",
            "rois.stream.connect_stream",
            "openrois.lease.query",
            "openrois.lease.request",
            "openrois.lease.leave",
            "openrois.lease.take",
            "openrois.lease.borrow",
            "openrois.lease.give_back",
        ),
        "component_ref",
    ),
    **dict.fromkeys(
        (
            "rois.stream.disconnect_stream",
            "rois.stream.suspend_stream",
            "rois.stream.resume_stream",
            "rois.stream.query_stream_status",
            "rois.stream.report_playout",
            "rois.stream.set_consent",
        ),
        "stream_id",
    ),
    **dict.fromkeys(("signaling.answer", "signaling.candidate", "signaling.restart"), "peer_id"),
    "rois.event.unsubscribe": "subscribe_id",
    "rois.event.get_event_detail": "event_id",
}
"""The member of the params that leads to the engine, by method."""

MOST_UNITS: Final = 1024
"""Commands of one sequence whose engines are looked up; a longer one goes where the first of them do."""


def engine_named(method: str, params: Mapping[str, Any]) -> str:
    """Return the engine that a request of one of `OF_ENGINE` is about; empty where it names none."""
    named = params.get(OF_ENGINE[method])
    return engine_of(named) if isinstance(named, str) else ""


def engines_commanded(params: Mapping[str, Any]) -> frozenset[str]:
    """Return the engines of the commands of `rois.command.execute`."""
    units = islice(_units(params), MOST_UNITS)
    refs = (unit.get("component_ref") for unit in units)
    return frozenset(engine_of(ref) for ref in refs if isinstance(ref, str))


def command_ids(params: Mapping[str, Any]) -> dict[str, str]:
    """Return the component of each command of `rois.command.execute`, by the command's id."""
    return {
        str(unit["command_id"]): str(unit.get("component_ref"))
        for unit in islice(_units(params), MOST_UNITS)
        if isinstance(unit.get("command_id"), str)
    }


def only_stops(params: Mapping[str, Any]) -> bool:
    """Tell whether all commands of `rois.command.execute` stop something: these do not wait for room."""
    kinds = [unit.get("command_type") for unit in islice(_units(params), MOST_UNITS + 1)]
    return 0 < len(kinds) <= MOST_UNITS and all(isinstance(kind, str) and is_stop(kind) for kind in kinds)


def _units(params: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    items = params.get("command_unit_list")
    for item in items if isinstance(items, list) else ():
        inner = item.get("command_list") if isinstance(item, dict) else None
        for unit in inner if isinstance(inner, list) else (item,):
            if isinstance(unit, dict):
                yield unit
