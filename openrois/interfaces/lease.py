"""`openrois.lease.*`: holding a component, requesting it, handing it over, resuming after a lost connection."""

from collections.abc import Iterable, Mapping
from typing import Any, Final

from openrois.errors import BadParameter, OutOfResources, RoISError, Unsupported
from openrois.interfaces import command
from openrois.interfaces.operation import shared_operation
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Reply
from openrois.leases.lease_notifications import session_of
from openrois.leases.model import Replayed
from openrois.scope.revocation import Entitlements
from openrois.session.session import ApplicationSession
from openrois.types.codes import ComponentFunction
from openrois.types.leases import (
    Lease,
    LeaseBorrowParams,
    LeaseParams,
    LeaseRequestParams,
    LeaseRequestResult,
    LeaseResult,
    LeaseTokenResult,
    LoanEnd,
    ResumeParams,
    ResumeResult,
)
from openrois.types.messages import NoParams, ReturnResult

__all__ = ["held_leases", "methods", "tell_missed"]

_MILLISECOND: Final = 0.001
_PUT_OUT: Final = "in the place of a connection that was not known to be lost"


def held_leases(app: ApplicationSession) -> tuple[Lease, ...]:
    """Return what a session holds and has named."""
    holding = app.host.leases.model.holding
    held = holding.held_by(app).items()
    return tuple(Lease(component_ref=ref, epoch=epoch) for ref, epoch in held if not holding.is_implied(ref))


def tell_missed(app: ApplicationSession, command_ids: Iterable[str]) -> None:
    """Notify how commands ended in the meantime; those that run are notified when they end."""
    for command_id in command_ids:
        ending = app.commands.ending(command_id)
        if ending is not None:
            app.completed(command_id, *ending)


class _Leases:
    """The operations of one application."""

    def __init__(self, app: ApplicationSession) -> None:
        self.app = app
        self._keeper = app.host.leases
        self._grace_ms = round(app.host.leases.model.rules.grace * 1000)

    def _require_leased(self, component_ref: str) -> None:
        if self.app.engine.require(component_ref).function is not ComponentFunction.ACTUATION:
            raise Unsupported(f"{component_ref} is no actuation component: it needs no lease")

    async def query(self, params: LeaseParams) -> LeaseResult:
        self._require_leased(params.component_ref)
        self._keeper.notifications.watch(params.component_ref, self.app)
        return LeaseResult(lease=self._keeper.notifications.status(params.component_ref, self.app))

    def _require_room(self, component_ref: str) -> None:
        """Raise `OutOfResources` where the application would have, or wait for, more components than it may bind."""
        chosen = self.app.bound.union(self._keeper.model.waited_for(self.app))
        if len(chosen) >= command.MAX_BOUND and component_ref not in chosen:
            raise OutOfResources(f"one application has at most {command.MAX_BOUND} components bound")

    async def request(self, params: LeaseParams) -> LeaseRequestResult:
        self._require_leased(params.component_ref)
        self._require_room(params.component_ref)
        self._keeper.notifications.watch(params.component_ref, self.app)
        request_id = self._keeper.request(params.component_ref, self.app)
        self._acted("openrois.lease.request", params.component_ref)
        lease = self._keeper.notifications.status(params.component_ref, self.app)
        return LeaseRequestResult(lease=lease, request_id=request_id)

    async def leave(self, params: LeaseParams) -> ReturnResult:
        self._require_leased(params.component_ref)
        self._keeper.withdraw(params.component_ref, self.app)
        return ReturnResult()

    async def grant(self, params: LeaseRequestParams) -> ReturnResult:
        component_ref = self._keeper.grant(params.request_id, self.app)
        self._acted("openrois.lease.grant", component_ref)
        return ReturnResult()

    async def decline(self, params: LeaseRequestParams) -> ReturnResult:
        self._keeper.decline(params.request_id, self.app)
        return ReturnResult()

    async def take(self, params: LeaseParams) -> LeaseResult:
        self._require_leased(params.component_ref)
        if not self.app.principal.is_administrator:
            raise Unsupported("only an administrator may take a component from its holder: request it instead")
        self._require_room(params.component_ref)
        self.app.host.audit.require()
        self._acted("openrois.lease.take", params.component_ref)
        await self._keeper.take(params.component_ref, self.app)
        return LeaseResult(lease=self._keeper.notifications.status(params.component_ref, self.app))

    async def borrow(self, params: LeaseBorrowParams) -> LeaseResult:
        component_ref = params.component_ref
        self._require_leased(component_ref)
        self._require_room(component_ref)
        self._require_rank(component_ref)
        self._keeper.notifications.watch(component_ref, self.app)
        self.app.host.audit.require()
        seconds = None if params.duration_ms is None else params.duration_ms * _MILLISECOND
        self._acted("openrois.lease.borrow", component_ref)
        for_one = params.ends_with is LoanEnd.COMMAND
        await self._keeper.borrow(component_ref, self.app, seconds, for_one=for_one)
        return LeaseResult(lease=self._keeper.notifications.status(component_ref, self.app))

    def _require_rank(self, component_ref: str) -> None:
        """Do nothing where the component is free, the application's own, or held by one of lower rank.

        Raises:
            OutOfResources: its holder is not of lower rank.
        """
        holding = self._keeper.model.holding
        holder = holding.holder_of(holding.part_of(component_ref))
        if holder is None or holder is self.app:
            return
        held_by = session_of(holder).principal
        if not self.app.host.ranks.is_above(self.app.principal, held_by):
            raise OutOfResources(
                f"{component_ref} is held by {held_by.subject}, which is not of lower rank than this application:"
                " request it instead"
            )

    async def give_back(self, params: LeaseParams) -> ReturnResult:
        self._require_leased(params.component_ref)
        self._keeper.hand_back(params.component_ref, self.app)
        self._acted("openrois.lease.give_back", params.component_ref)
        return ReturnResult()

    async def token(self, _params: NoParams) -> LeaseTokenResult:
        return LeaseTokenResult(token=self._keeper.token(self.app), grace_ms=self._grace_ms)

    async def resume(self, params: ResumeParams) -> Reply:
        if self._keeper.model.has_any(self.app) or self.app.commands.unfinished:
            raise BadParameter("resume before binding or executing anything that acts")
        try:
            former = self._keeper.resume(params.token, self.app)
        except RoISError as error:
            reason = "a resume token was used twice" if isinstance(error, Replayed) else str(error)
            self.app.host.audit.refused(self.app.principal, "openrois.lease.resume", "", reason)
            raise
        assert isinstance(former, ApplicationSession)
        was_lost = former.closed
        self.app.succeed(former)
        for component_ref in Entitlements(self.app.principal).lost_bindings(tuple(self.app.bound)):
            self.app.give_back(component_ref)
            self.app.bound.discard(component_ref)
        held = held_leases(self.app)
        self.app.host.audit.acted(
            self.app.principal,
            "openrois.lease.resume",
            " ".join(sorted(each.component_ref for each in held)),
            "" if was_lost else _PUT_OUT,
        )
        result = ResumeResult(
            token=self._keeper.token(self.app),
            grace_ms=self._grace_ms,
            leases=held,
            forgotten=tuple(command_id for command_id in params.command_ids if command_id not in self.app.commands),
        )
        return Reply(result, lambda: tell_missed(self.app, params.command_ids))

    def _acted(self, method: str, component_ref: str) -> None:
        self.app.host.audit.acted(self.app.principal, method, component_ref)


def _extending(method: SharedMethod) -> SharedMethod:
    async def answer(leases: _Leases, params: dict[str, Any]) -> Any:
        leases.app.extended = leases.app.leasing = True
        return await method(leases, params)

    return answer


_OPERATIONS: Final[Mapping[str, SharedMethod]] = {
    "openrois.lease.query": shared_operation(LeaseParams, LeaseResult, _Leases.query),
    "openrois.lease.request": shared_operation(LeaseParams, LeaseRequestResult, _Leases.request),
    "openrois.lease.leave": shared_operation(LeaseParams, ReturnResult, _Leases.leave),
    "openrois.lease.grant": shared_operation(LeaseRequestParams, ReturnResult, _Leases.grant),
    "openrois.lease.decline": shared_operation(LeaseRequestParams, ReturnResult, _Leases.decline),
    "openrois.lease.take": shared_operation(LeaseParams, LeaseResult, _Leases.take),
    "openrois.lease.borrow": shared_operation(LeaseBorrowParams, LeaseResult, _Leases.borrow),
    "openrois.lease.give_back": shared_operation(LeaseParams, ReturnResult, _Leases.give_back),
    "openrois.lease.token": shared_operation(NoParams, LeaseTokenResult, _Leases.token),
    "openrois.lease.resume": shared_operation(ResumeParams, ResumeResult, _Leases.resume),
}
_METHODS: Final = {name: _extending(each) for name, each in _OPERATIONS.items()}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the extension's methods; an application that calls one gets the notifications of extensions."""
    return BoundMethods((_METHODS, _Leases(app)))
