"""`openrois.stop_all`: everything that acts on an engine stops, for an application that sees a part of what acts.

Where a person asks for it, programs wait then until a person hands the engine back: `openrois.lease.release_stop`.
"""

from collections.abc import Iterable, Mapping
from typing import Final

from openrois.commands.stop import stop_components
from openrois.errors import BadParameter, Unsupported
from openrois.interfaces.operation import shared_operation
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Reply
from openrois.session.session import ApplicationSession
from openrois.types.codes import ReturnCode
from openrois.types.leases import StopAllParams, StopAllResult
from openrois.types.messages import ReturnResult
from openrois.types.references import engine_of
from openrois.types.stops import ReleaseStopParams, new_stop_id

__all__ = ["methods"]

_METHOD: Final = "openrois.stop_all"
_RELEASE: Final = "openrois.lease.release_stop"


async def _stop_all(app: ApplicationSession, params: StopAllParams) -> Reply:
    refs, stop_id = _chosen(app, params), params.stop_id or new_stop_id()
    for engine_id in sorted({engine_of(ref) for ref in refs}):
        is_latched = app.host.stops.stop(engine_id, app.principal, stop_id)
        app.host.audit.acted(app.principal, _METHOD, engine_id, "programs wait" if is_latched else "")
    reason = f"everything was stopped by {app.principal.subject}"
    failures = await stop_components(app.host.engine, app.host.pending, app.host.tasks, refs, reason)
    shown = [ref for ref in refs if app.engine.sees(ref)]
    failed = {ref: failures[ref] for ref in shown if failures[ref]}
    stopped = tuple(ref for ref in shown if ref not in failed)
    if not failed:
        return Reply(StopAllResult(stopped=stopped))
    result = StopAllResult(return_code=ReturnCode.ERROR, stopped=stopped, failed=tuple(failed))
    return Reply(result, reason="; ".join(f"{ref}: {failure}" for ref, failure in failed.items()))


async def _release_stop(app: ApplicationSession, params: ReleaseStopParams) -> ReturnResult:
    if (params.engine_id is None) == (params.component_ref is None):
        raise BadParameter("give either an engine_id or a component_ref")
    engine_id = _engine_named(app, params)
    if not app.host.ranks.may_hand_back(app.principal, app.host.stop_latch.by(engine_id)):
        raise Unsupported("only a person hands back to programs what a person has stopped")
    by = app.host.stops.release(engine_id, app.principal, params.stop_id or "")
    app.host.audit.acted(app.principal, _RELEASE, engine_id, f"stopped by {by}" if by else "it was not stopped")
    return ReturnResult()


_METHODS: Final[Mapping[str, SharedMethod]] = {
    _METHOD: shared_operation(StopAllParams, StopAllResult, _stop_all),
    _RELEASE: shared_operation(ReleaseStopParams, ReturnResult, _release_stop),
}


def methods(app: ApplicationSession) -> BoundMethods:
    """Return the interface's methods."""
    return BoundMethods((_METHODS, app))


def _chosen(app: ApplicationSession, params: StopAllParams) -> list[str]:
    """Return the actuation components that are to be stopped: all of an engine, also those out of scope.

    Raises:
        BadParameter: two engines are named, or might be.
        Unsupported: there is no such engine or component, or nothing in scope acts there.
    """
    if params.engine_id is not None and params.component_ref is not None:
        raise BadParameter("give either an engine_id or a component_ref, not both")
    if params.engine_id is None and params.component_ref is None:
        return [ref for engine_id in _controlled(app) for ref in _acting(app, engine_id)]
    return _acting(app, _engine_named(app, params))


def _engine_named(app: ApplicationSession, params: StopAllParams | ReleaseStopParams) -> str:
    """Return the engine that is to be stopped, or handed back.

    Raises:
        Unsupported: there is no such engine or component, or nothing in scope acts there.
    """
    if params.component_ref is not None:
        app.engine.require(params.component_ref)
    engine_id = params.engine_id or engine_of(params.component_ref or "")
    if not app.engine.tree.refs_of(engine_id):
        raise Unsupported(f"there is no engine {engine_id[:200]!r}")
    if not any(app.engine.sees(ref) for ref in _acting(app, engine_id)):
        raise Unsupported(f"there is no actuation component of {engine_id}")
    return engine_id


def _acting(app: ApplicationSession, engine_id: str) -> list[str]:
    """Return the actuation components of an engine, also those that are out of the application's scope."""
    return app.host.engine.acting_of(engine_id)


def _controlled(app: ApplicationSession) -> Iterable[str]:
    """Return the engines of which the application controls a part; an administrator controls all that it sees."""
    refs = app.engine.components if app.principal.is_administrator else app.host.leases.model.holding.held_by(app)
    return dict.fromkeys(map(engine_of, refs))
