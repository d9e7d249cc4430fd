"""The faults that one application was notified of, and their details. Pure."""

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
class _Notified:
    component_ref: str
    results: tuple[Result, ...]


class ErrorLog:
    """Faults that this application was notified of: those of others look like unknown ones."""

    def __init__(self) -> None:
        self._notified: BoundedHistory[_Notified] = BoundedHistory(MAX_ERRORS)

    def note(self, fault: Fault) -> None:
        """Add a fault; the oldest of too many is dropped."""
        results = _error_results(fault)
        self._notified.put(fault.error_id, _Notified(fault.component_ref, results), results)

    def details(self, error_id: str, sees: Callable[[str], bool] = lambda _component_ref: True) -> tuple[Result, ...]:
        """Return the details of a fault.

        Args:
            error_id: the fault.
            sees: tells whether a component is in the application's scope, which may have changed.

        Raises:
            BadParameter: this application was never notified of it, it was dropped, or its component is out of scope by
                now.
        """
        notice = self._notified.get(error_id)
        if notice is None or (notice.component_ref and not sees(notice.component_ref)):
            raise BadParameter(f"there is no error {error_id[:200]!r}")
        return notice.results


def _error_results(fault: Fault) -> tuple[Result, ...]:
    """Return a fault as the results of get_error_detail."""
    return (
        Result(name="component_ref", data_type_ref="RoISIdentifier", value=fault.component_ref),
        Result(name="error_type", data_type_ref="ErrorType", value=fault.error_type.value),
        Result(name="description", data_type_ref="string", value=fault.description),
        Result(name="timestamp", data_type_ref="DateTime", value=fault.timestamp),
    )
