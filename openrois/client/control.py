"""Leases in the client: requesting a component, handing it over, and stopping everything."""

from collections.abc import Callable
from typing import Any, Final

from openrois.client.bindings import Bindings
from openrois.client.connection import Connection
from openrois.client.errors import ConnectionLost
from openrois.client.feed import Feed
from openrois.client.notices import (
    ControlChanged,
    ControlDeclined,
    ControlRequested,
    ControlStopped,
    ControlWithdrawn,
    Disconnected,
    Notice,
    ProfileChanged,
)
from openrois.client.rpc_call import read_message
from openrois.errors import OutOfResources, RoISError
from openrois.jsonrpc.session import RpcError
from openrois.types.leases import (
    LeaseBorrowParams,
    LeaseChangedNotification,
    LeaseDeclinedNotification,
    LeaseParams,
    LeaseRequestedNotification,
    LeaseRequestParams,
    LeaseRequestResult,
    LeaseResult,
    LeaseState,
    LeaseStatus,
    LeaseWithdrawnNotification,
    LoanEnd,
    StopAllParams,
    StopAllResult,
)
from openrois.types.messages import ComponentParams, ReturnResult
from openrois.types.references import engine_of
from openrois.types.stops import ReleaseStopParams, StoppedNotification

__all__ = ["Control", "control_notice"]

_MILLISECOND: Final = 0.001

_MAX_TOLD: Final = 1024
"""Engines that are stopped whose STOP a client remembers."""


class Control:
    """The leases of a client; `client.control`. Everything raises as the other operations of a client do.

    Args:
        connection: of the client.
        bindings: what it has.
        listen: returns what the client tells from now on, of some kinds.
    """

    def __init__(self, connection: Connection, bindings: Bindings, listen: Callable[..., Feed[Any]]) -> None:
        self._connection = connection
        self._bindings = bindings
        self._listen = listen
        self._told = _ToldStops()

    def handle_notice(self, notice: Notice) -> None:
        """Note which STOP holds, so that a hand-back names it."""
        if isinstance(notice, ControlStopped):
            self._told.note(notice.engine_id, notice.stop_id if notice.by else "")

    async def status(self, component_ref: str) -> LeaseStatus:
        """Return the lease of a component; from then on `ControlChanged` reports when that changes.

        Raises:
            Unsupported: there is no such component.
        """
        result = await self._connection.ask("openrois.lease.query", _params(component_ref), LeaseResult)
        lease = result.lease or LeaseStatus()
        self._told.note(engine_of(component_ref), lease.stop_id)
        return lease

    async def request(self, component_ref: str, *, wait: bool = False) -> None:
        """Request a component of its holder, and return once it is bound; a free one is bound at once.

        Args:
            component_ref: the component.
            wait: stay in line when the holder says no, until it is given back.

        Raises:
            OutOfResources: the holder said no, or nothing in time; or too many wait.
            Unsupported: there is no such component (any more).
            TimeoutError: the gateway has not answered in time; nothing is asked any more.
            ConnectionLost: the connection ended, and with it the place in line.
        """
        feed = self._listen(ControlChanged, ControlDeclined, ProfileChanged, Disconnected)
        try:
            answer = await self._connection.act(
                "openrois.lease.request",
                _params(component_ref),
                LeaseRequestResult,
                too_late=lambda _: self._give_up(component_ref),
            )
        except (RoISError, RpcError):
            # It was refused, and nothing of it is left there.
            raise
        except BaseException:
            self._give_up(component_ref)
            raise
        try:
            if answer.lease is None or answer.lease.state is not LeaseState.MINE:
                await self._granted(feed, component_ref, answer.request_id, wait)
        except BaseException:
            self._give_up(component_ref)
            raise
        self._bindings.use(component_ref)

    def _give_up(self, component_ref: str) -> None:
        """Leave the queue for a component, which may have become ours in the same moment."""
        self._connection.post("openrois.lease.leave", _params(component_ref))
        if not self._bindings.wants(component_ref):
            self._connection.post("rois.command.release", ComponentParams(component_ref=component_ref))

    async def _granted(self, feed: Feed[Any], component_ref: str, request_id: str, wait: bool) -> None:
        async for notice in feed:
            match notice:
                case ControlChanged(ref, LeaseState.MINE) if ref == component_ref:
                    return
                case ControlDeclined(_, asked, reason) if asked == request_id and not wait:
                    raise OutOfResources(f"{component_ref}: {reason}")
                case ControlDeclined() | ProfileChanged():
                    # It may be gone, also for a moment, or not be shown to this application any more.
                    await self._require_place(component_ref)
                case Disconnected(reason):
                    raise ConnectionLost(f"openrois.lease.request: {reason}")
        raise ConnectionLost("openrois.lease.request: the client is closed")

    async def _require_place(self, component_ref: str) -> None:
        """Do nothing while waiting in the queue for a component, or once it is held."""
        lease = (await self._connection.act("openrois.lease.query", _params(component_ref), LeaseResult)).lease
        if lease is None or not (lease.position or lease.state is LeaseState.MINE):
            raise OutOfResources(f"{component_ref}: the request for it was dropped: request it again")

    async def grant(self, request_id: str) -> None:
        """Hand the component over to the application that requests it (`ControlRequested`); what runs ends with ABORT.

        Raises:
            Unsupported: there is no such request (any more).
        """
        await self._connection.act("openrois.lease.grant", LeaseRequestParams(request_id=request_id), ReturnResult)

    async def decline(self, request_id: str) -> None:
        """Keep the component that another application requests (`ControlRequested`).

        Raises:
            Unsupported: there is no such request (any more).
        """
        await self._connection.act("openrois.lease.decline", LeaseRequestParams(request_id=request_id), ReturnResult)

    async def take(self, component_ref: str) -> None:
        """Bind a component as an administrator, also one that another application holds; its commands end with ABORT.

        Raises:
            Unsupported: there is no such component, or this application is no administrator.
        """
        await self._connection.act("openrois.lease.take", _params(component_ref), LeaseResult)
        self._bindings.use(component_ref)

    async def borrow(
        self, component_ref: str, *, seconds: float | None = None, for_one_command: bool = False
    ) -> LeaseStatus:
        """Take a component with its part for a time from an application of lower rank, which has it back afterwards.

        What runs there ends with ABORT. A free component is simply bound. Borrow it again to have it for longer, and
        give it back (`give_back`) as soon as it is not needed.

        Args:
            component_ref: the component.
            seconds: for which it is taken; what the gateway is configured for (30 s) unless given.
            for_one_command: give it back by itself when the next `start` has ended.

        Returns:
            The lease now.

        Raises:
            OutOfResources: its holder is not of lower rank: request it instead.
            Unsupported: there is no such component, or the gateway knows no loans.
        """
        duration = None if seconds is None else round(seconds / _MILLISECOND)
        ends_with = LoanEnd.COMMAND if for_one_command else LoanEnd.TIME
        params = LeaseBorrowParams(component_ref=component_ref, duration_ms=duration, ends_with=ends_with)
        lease = (await self._connection.act("openrois.lease.borrow", params, LeaseResult)).lease
        self._bindings.use(component_ref)
        return lease or LeaseStatus()

    async def give_back(self, component_ref: str) -> None:
        """Release all of the part of a component: an application from which it was taken for a time has it back.

        Raises:
            Unsupported: there is no such component.
        """
        await self._connection.act("openrois.lease.give_back", _params(component_ref), ReturnResult)
        self._bindings.gave_back(component_ref)

    async def stop_all(self, engine_id: str | None = None, *, component_ref: str | None = None) -> tuple[str, ...]:
        """Stop everything that acts on an engine, and return which components have stopped.

        Where this application is a person's, programs wait then until a person calls `release_stop`.

        Args:
            engine_id: the engine.
            component_ref: a component of the engine, in place of its id. Without both it is every engine of which
                this application holds something; of an administrator every engine that it sees.

        Raises:
            ComponentFailed: something did not say that it has stopped; all commands have ended with ABORT all the same.
            Unsupported: there is no such engine, or nothing that acts there is in scope.
        """
        params = StopAllParams(engine_id=engine_id, component_ref=component_ref)
        return (await self._connection.act("openrois.stop_all", params, StopAllResult)).stopped

    async def release_stop(self, engine_id: str) -> None:
        """Hand a body that a person has stopped back to programs, as a person; one that is not stopped stays so.

        It ends the STOP that this client was told last (`ControlStopped`, `status`), and no later one; where it was
        told none, whichever holds.

        Raises:
            OutOfResources: it was stopped again meanwhile: look again, and hand it back anew.
            Unsupported: there is no such engine, nothing that acts there is in scope, or this application is a program.
        """
        params = ReleaseStopParams(engine_id=engine_id, stop_id=self._told.pop(engine_id))
        await self._connection.act("openrois.lease.release_stop", params, ReturnResult)


class _ToldStops:
    """The ids of the STOPs that a client was told, by engine."""

    def __init__(self) -> None:
        self._ids: dict[str, str] = {}

    def note(self, engine_id: str, stop_id: str) -> None:
        """Note the STOP that holds; empty for none. Of too many the first one is forgotten."""
        self._ids.pop(engine_id, None)
        if stop_id:
            self._ids[engine_id] = stop_id
        if len(self._ids) > _MAX_TOLD:
            del self._ids[next(iter(self._ids))]

    def pop(self, engine_id: str) -> str | None:
        """Return the STOP that is to end, and forget it: a hand-back that is refused is asked for anew."""
        return self._ids.pop(engine_id, None)


def control_notice(method: str, params: dict[str, Any]) -> Notice | None:
    """Return the notice for a notification of leases; None for any other."""
    match method:
        case LeaseChangedNotification.method:
            now = read_message(LeaseChangedNotification, params)
            return ControlChanged(
                now.component_ref,
                now.state,
                now.holder,
                now.waiting,
                now.position,
                now.reason,
                now.part,
                now.lender,
                now.return_ms * _MILLISECOND,
                now.return_position,
            )
        case LeaseRequestedNotification.method:
            asked = read_message(LeaseRequestedNotification, params)
            return ControlRequested(
                asked.component_ref, asked.request_id, asked.subject, asked.answer_ms * _MILLISECOND
            )
        case LeaseDeclinedNotification.method:
            declined = read_message(LeaseDeclinedNotification, params)
            return ControlDeclined(declined.component_ref, declined.request_id, declined.reason)
        case LeaseWithdrawnNotification.method:
            withdrawn = read_message(LeaseWithdrawnNotification, params)
            return ControlWithdrawn(withdrawn.component_ref, withdrawn.request_id)
        case StoppedNotification.method:
            stopped = read_message(StoppedNotification, params)
            return ControlStopped(stopped.engine_id, stopped.by, stopped.reason, stopped.stop_id)
    return None


def _params(component_ref: str) -> LeaseParams:
    return LeaseParams(component_ref=component_ref)
