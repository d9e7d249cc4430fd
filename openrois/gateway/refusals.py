"""Refused requests of an application in the audit trail, at a bounded rate; failures are no refusals."""

import re
import time
from collections.abc import Callable, Mapping
from typing import Any, Final

from openrois.gateway.audit_rate import AuditRate
from openrois.gateway.renewal import REFRESH
from openrois.session.session import ApplicationSession
from openrois.types.codes import ReturnCode

__all__ = ["RefusalNotes"]

REFUSALS_AT_ONCE: Final = 100
"""Refusals of one application that the audit trail records one by one."""

REFUSALS_PER_SECOND: Final = 10
"""Of them in the long run; of more the next record says how many there were."""

_REFUSALS: Final = {ReturnCode.BAD_PARAMETER, ReturnCode.UNSUPPORTED, ReturnCode.OUT_OF_RESOURCES}
_SUBJECTS: Final = (
    *("component_ref", "stream_id", "peer_id", "command_id", "subscribe_id", "event_id", "error_id"),
    *("condition", "event_type", "query_type", "engine_id"),
)

_NAMED: Final = re.compile(r"component_ref\s*+=\s*+'((?:[^']|'')*+)'")


class RefusalNotes:
    """Records the refusals of one application at a bounded rate: it must not fill a disk.

    Args:
        app: the session of the application.
        clock: monotonic seconds.
    """

    def __init__(self, app: ApplicationSession, clock: Callable[[], float] = time.monotonic) -> None:
        self._app = app
        self._audit_rate = AuditRate(REFUSALS_AT_ONCE, REFUSALS_PER_SECOND, clock)

    def note(self, method: str, params: Mapping[str, Any], result: Any, reason: str) -> None:
        """Record that a call was refused, if its result is a refusal and no failure.

        Args:
            method: what was called.
            params: with which params, of which the record names what the call was about.
            result: the model or object that is answered.
            reason: why.
        """
        code = result.get("return_code") if isinstance(result, dict) else getattr(result, "return_code", None)
        if code not in _REFUSALS or (method == REFRESH and code is ReturnCode.BAD_PARAMETER):
            # The reason of a refused token is recorded by `note_token`.
            return
        if not self._audit_rate.admits():
            return
        subject, refs = _subject(params), _refs(params)
        # Looked up also for what is absent, so that both take the same time; the reason goes to the trail alone.
        hidden = [ref for ref in refs if self._app.engine.hides(ref)]
        self._record(method, subject, f"{code}: {reason}" + (f" (out of scope: {hidden[0][:200]})" if hidden else ""))

    def note_token(self, reason: str) -> None:
        """Record that a new token was refused, and why; the application does not learn why."""
        if self._audit_rate.admits():
            self._record(REFRESH, "", reason)

    def _record(self, method: str, subject: str, told: str) -> None:
        self._app.host.audit.refused(self._app.principal, method, subject, self._audit_rate.told(told))


def _subject(params: Mapping[str, Any]) -> str:
    """Return the most telling of the ids and conditions in the params, which may hold anything."""
    return next((str(each[name]) for each in (params, *_units(params)) for name in _SUBJECTS if each.get(name)), "")


def _units(params: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the commands in the params, at any depth of a sequence."""
    items = params.get("command_unit_list")
    found: list[Mapping[str, Any]] = []
    for item in items if isinstance(items, list) else ():
        inner = item.get("command_list", [item]) if isinstance(item, dict) else ()
        found += [each for each in inner if isinstance(each, dict)] if isinstance(inner, list) else []
    return found


def _refs(params: Mapping[str, Any]) -> list[str]:
    """Return the references that the params name, in a condition too."""
    found = [each.get("component_ref") for each in (params, *_units(params))]
    condition = params.get("condition")
    if isinstance(condition, str) and (named := _NAMED.search(condition)):
        found.append(named[1].replace("''", "'"))
    return [ref for ref in found if isinstance(ref, str)]
