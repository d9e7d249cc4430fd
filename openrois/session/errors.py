"""The faults that one application was told, and what it may ask about them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from openrois.aio.bounded_history import BoundedHistory
from openrois.contract import Fault
from openrois.errors import BadParameter
from openrois.types.messages import Result

__all__ = ["ErrorLog"]

MAX_ERRORS: Final = 256


@dataclass(frozen=True, slots=True)
class _Told:
    component_ref: str
    results: tuple[Result, ...]


class ErrorLog:
    """Error ids that this application was told: those of others look like ones that do not exist."""

    def __init__(self) -> None:
        self._told: BoundedHistory[_Told] = BoundedHistory(MAX_ERRORS)

    def note(self, fault: Fault) -> None:
        """Remember a fault; the oldest of too many is forgotten."""
        results = _error_results(fault)
        self._told.put(fault.error_id, _Told(fault.component_ref, results), results)

    def details(self, error_id: str, sees: Callable[[str], bool] = lambda _component_ref: True) -> tuple[Result, ...]:
        """Return what is known of a fault.

        Args:
            error_id: the fault.
            sees: tells whether a component is in the application's scope, which may have changed.

        Raises:
            BadParameter: this application was never told of it, it is forgotten, or its component is out of scope by
                now.
        """
        told = self._told.get(error_id)
        if told is None or (told.component_ref and not sees(told.component_ref)):
            raise BadParameter(f"there is no error {error_id[:200]!r}")
        return told.results


def _error_results(fault: Fault) -> tuple[Result, ...]:
    """Return a fault as the results of get_error_detail."""
    return (
        Result(name="component_ref", data_type_ref="RoISIdentifier", value=fault.component_ref),
        Result(name="error_type", data_type_ref="ErrorType", value=fault.error_type.value),
        Result(name="description", data_type_ref="string", value=fault.description),
        Result(name="timestamp", data_type_ref="DateTime", value=fault.timestamp),
    )
