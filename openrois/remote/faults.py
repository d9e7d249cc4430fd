"""Faults that a remote engine notifies: their component is queried, because the notification does not have it."""

import logging
import time
from collections.abc import Awaitable, Callable
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.contract import Fault, OnFault, ignore_fault
from openrois.engine.faults import MAX_DESCRIPTION, fault_limit
from openrois.errors import RoISError
from openrois.observability.logs import Tally
from openrois.remote.remote_profile import RemoteProfile
from openrois.types.messages import ErrorNotification, ResultsResult
from openrois.types.values import date_time

__all__ = ["RemoteFaults"]

_log = logging.getLogger(__name__)

_MAX_TIMESTAMP: Final = 64


class RemoteFaults:
    """The faults of a remote engine and of those below it.

    Args:
        ask: asks the other side for the details of an error.
        remote_profile: which ids are the other side's.
        tasks: owns the questions.

    Attributes:
        on_fault: gets them.
    """

    def __init__(
        self, ask: Callable[[str], Awaitable[ResultsResult]], remote_profile: RemoteProfile, tasks: TaskScope
    ) -> None:
        self.on_fault: OnFault = ignore_fault
        self._ask = ask
        self._remote_profile = remote_profile
        self._tasks = tasks
        self._limit = fault_limit()
        self._foreign = Tally(_log, "faults with an id or a component of another engine")
        self._untold = Tally(
            _log, "faults of a remote engine that were not reported, too many at a time", logging.WARNING
        )

    def handle_notification(self, params: dict[str, Any]) -> None:
        """Handle a notification and query its details; of too many the rest is counted."""
        notice = ErrorNotification.read_newer(params)
        if not self._remote_profile.is_own(notice.error_id):
            self._foreign.note(f"the id {notice.error_id[:200]!r}")
        elif not self._limit.admits():
            self._untold.note(notice.error_id[:200])
        else:
            self._tasks.start(self._find_out(notice))

    async def _find_out(self, notice: ErrorNotification) -> None:
        details: dict[str, str] = {}
        try:
            answer = await self._ask(notice.error_id)
            details = {result.name: result.value for result in answer.results}
        except RoISError as error:
            # An engine of the plain wire may know no details: then the fault is the engine's own.
            _log.debug("there are no details of %s: %s", notice.error_id, error)
        component_ref = details.get("component_ref", "")
        if component_ref and self._remote_profile.profile(component_ref) is None:
            self._foreign.note(f"the component {component_ref[:200]!r}")
            component_ref = ""
        self.on_fault(
            Fault(
                error_id=notice.error_id,
                error_type=notice.error_type,
                component_ref=component_ref,
                description=details.get("description", "")[:MAX_DESCRIPTION],
                timestamp=details.get("timestamp", "")[:_MAX_TIMESTAMP] or date_time(time.time()),
            )
        )
