"""The faults that one application was told, and what it may ask about them."""

from collections import OrderedDict
from typing import Final

from openrois.contract import Fault
from openrois.errors import BadParameter
from openrois.types.messages import Result

__all__ = ["ErrorLog", "error_results"]

MAX_ERRORS: Final = 256


class ErrorLog:
    """Error ids that this application was told: those of others look like ones that do not exist."""

    def __init__(self) -> None:
        self._told: OrderedDict[str, tuple[Result, ...]] = OrderedDict()

    def note(self, fault: Fault) -> None:
        """Remember a fault; the oldest of too many is forgotten."""
        self._told[fault.error_id] = error_results(fault)
        while len(self._told) > MAX_ERRORS:
            self._told.popitem(last=False)

    def details(self, error_id: str) -> tuple[Result, ...]:
        """Return what is known of a fault.

        Raises:
            BadParameter: this application was never told of it, or it is forgotten.
        """
        if error_id not in self._told:
            raise BadParameter(f"there is no error {error_id[:200]!r}")
        return self._told[error_id]


def error_results(fault: Fault) -> tuple[Result, ...]:
    """Return a fault as the results of get_error_detail."""
    return (
        Result(name="component_ref", data_type_ref="RoISIdentifier", value=fault.component_ref),
        Result(name="error_type", data_type_ref="ErrorType", value=fault.error_type.value),
        Result(name="description", data_type_ref="string", value=fault.description),
        Result(name="timestamp", data_type_ref="DateTime", value=fault.timestamp),
    )
