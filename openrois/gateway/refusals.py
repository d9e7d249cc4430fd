"""What an application was refused, told to the audit trail; what failed is no refusal."""

from collections.abc import Mapping
from typing import Any, Final

from openrois.application import ApplicationSession
from openrois.types.codes import ReturnCode

__all__ = ["note_refusal"]

_REFUSALS: Final = {ReturnCode.BAD_PARAMETER, ReturnCode.UNSUPPORTED, ReturnCode.OUT_OF_RESOURCES}
_SUBJECTS: Final = (
    *("component_ref", "stream_id", "peer_id", "command_id", "subscribe_id", "event_id", "error_id"),
    *("condition", "event_type", "query_type"),
)


def note_refusal(app: ApplicationSession, method: str, params: Mapping[str, Any], result: Any, reason: str) -> None:
    """Record that a call of the application was refused, if its result is a refusal and no failure.

    Args:
        app: who called.
        method: what it called.
        params: with which params, of which the record names what the call was about.
        result: the model or object that is answered.
        reason: why.
    """
    code = result.get("return_code") if isinstance(result, dict) else getattr(result, "return_code", None)
    if code in _REFUSALS:
        app.host.audit.refused(app.principal, method, _subject(params), f"{code}: {reason}")


def _subject(params: Mapping[str, Any]) -> str:
    """Return the most telling of the ids and conditions in the params; whoever sent them may have sent anything."""
    units = params.get("command_unit_list")
    if isinstance(units, list) and units and isinstance(units[0], dict):
        params = units[0]
    return next((str(params[name]) for name in _SUBJECTS if params.get(name)), "")
