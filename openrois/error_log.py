"""The faults that one application was told, and what it may ask about them."""

from typing import Final

from openrois.contract import Fault
from openrois.errors import BadParameter
from openrois.remembered import Remembered
from openrois.types.messages import Result

__all__ = ["ErrorLog", "error_results"]

MAX_ERRORS: Final = 256


class ErrorLog:
    """Error ids that this application was told: those of others look like ones that do not exist."""

    def __init__(self) -> None:
        self._told: Remembered[tuple[Result, ...]] = Remembered(MAX_ERRORS)

    def note(self, fault: Fault) -> None:
        """Remember a fault; the oldest of too many is forgotten."""
        results = error_results(fault)
        self._told.put(fault.error_id, results, results)

    def details(self, error_id: str) -> tuple[Result, ...]:
        """Return what is known of a fault.

        Raises:
            BadParameter: this application was never told of it, or it is forgotten.
        """
        results = self._told.get(error_id)
        if results is None:
            raise BadParameter(f"there is no error {error_id[:200]!r}")
        return results


def error_results(fault: Fault) -> tuple[Result, ...]:
    """Return a fault as the results of get_error_detail."""
    return (
        Result(name="component_ref", data_type_ref="RoISIdentifier", value=fault.component_ref),
        Result(name="error_type", data_type_ref="ErrorType", value=fault.error_type.value),
        Result(name="description", data_type_ref="string", value=fault.description),
        Result(name="timestamp", data_type_ref="DateTime", value=fault.timestamp),
    )
