"""Rules for requests under overload: those that stop, release and leave come first, others are refused.

A stop that passes what waits has to be the last word: what was asked before it of the same components is refused.
"""

from collections.abc import Iterator
from itertools import islice
from typing import Any, Final

from openrois.aio.rate import RateLimit
from openrois.jsonrpc.protocol import Request
from openrois.jsonrpc.request_queue import QueueRules
from openrois.types.codes import ReturnCode
from openrois.types.messages import ReturnResult
from openrois.types.methods import METHODS

__all__ = ["is_stop", "is_urgent", "meant", "named", "queue_rules", "refusal"]

MAX_UNITS: Final = 64
"""Commands of a sequence that may pass others, if all of them are `stop`."""

MOST_UNITS: Final = 1024
"""Commands of a request that are examined; a longer one may concern any component."""

_EXECUTE: Final = "rois.command.execute"
_URGENT: Final = frozenset({"rois.command.release", "rois.system.disconnect", "openrois.stop_all"})
_ACTING: Final = frozenset({_EXECUTE, "rois.command.set_parameter", "rois.command.bind", "rois.command.bind_any"})
_RESULTS: Final = {method.name: method.result for method in METHODS}


def queue_rules(rate: RateLimit | None = None) -> QueueRules:
    """Return the rules of a connection that speaks RoIS."""
    return QueueRules(is_urgent, meant, named, refusal, rate)


def refusal(method: str) -> ReturnResult | None:
    """Return the answer to a request that is refused under overload; None for an unknown method."""
    result = _RESULTS.get(method)
    return None if result is None else result(return_code=ReturnCode.OUT_OF_RESOURCES)


def is_stop(command_type: str) -> bool:
    """Tell whether a command does nothing but end what runs."""
    return command_type == "stop"


def is_urgent(request: Request) -> bool:
    """Tell whether a request stops, releases or leaves. Whether it fits is not checked yet."""
    if request.method != _EXECUTE:
        return request.method in _URGENT
    units = list(islice(_units(request.params), MAX_UNITS + 1))
    return 0 < len(units) <= MAX_UNITS and all(is_stop(str(unit.get("command_type"))) for unit in units)


def meant(request: Request) -> frozenset[str]:
    """Return the components that an urgent request concerns; nothing where it names none, and may mean any."""
    params = request.params
    named = (params.get("component_ref"),) if isinstance(params, dict) else ()
    units = list(islice(_units(params), MOST_UNITS + 1))
    if len(units) > MOST_UNITS:
        return frozenset()
    return frozenset(ref for ref in (*named, *(unit.get("component_ref") for unit in units)) if isinstance(ref, str))


def named(request: Request) -> frozenset[str] | None:
    """Return the components that a request would act on, as `meant` does; None where it does not act."""
    return meant(request) if request.method in _ACTING else None


def _units(params: Any) -> Iterator[dict[str, Any]]:
    """Yield the command units of what may be the params of execute, those of concurrent commands, too."""
    items = params.get("command_unit_list") if isinstance(params, dict) else None
    for item in items if isinstance(items, list) else ():
        inner = item.get("command_list") if isinstance(item, dict) else None
        for unit in inner if isinstance(inner, list) else (item,):
            yield unit if isinstance(unit, dict) else {}
