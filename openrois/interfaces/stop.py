"""`openrois.stop_all`: everything that acts on an engine stops, for an application that controls a part of it."""

from typing import Final

from openrois.commands.stop import stop_components
from openrois.errors import BadParameter, OutOfResources, Unsupported
from openrois.interfaces.operation import operation
from openrois.jsonrpc.session import Handler, Reply
from openrois.session.session import ApplicationSession
from openrois.types.codes import ComponentFunction, ReturnCode
from openrois.types.leases import StopAllParams, StopAllResult
from openrois.types.references import engine_of

__all__ = ["methods"]

_METHOD: Final = "openrois.stop_all"


def methods(app: ApplicationSession) -> dict[str, Handler]:
    """Return the method table."""

    async def stop_all(params: StopAllParams) -> Reply:
        refs = _chosen(app, params)
        for engine_id in sorted({engine_of(ref) for ref in refs}):
            app.host.audit.acted(app.principal, _METHOD, engine_id)
        reason = f"everything was stopped by {app.principal.subject}"
        failures = await stop_components(app.host.engine, app.host.pending, app.host.tasks, refs, reason)
        shown = [ref for ref in refs if app.engine.sees(ref)]
        failed = {ref: failures[ref] for ref in shown if failures[ref]}
        stopped = tuple(ref for ref in shown if ref not in failed)
        if not failed:
            return Reply(StopAllResult(stopped=stopped))
        result = StopAllResult(return_code=ReturnCode.ERROR, stopped=stopped, failed=tuple(failed))
        return Reply(result, reason="; ".join(f"{ref}: {failure}" for ref, failure in failed.items()))

    return {_METHOD: operation(StopAllParams, StopAllResult, stop_all)}


def _chosen(app: ApplicationSession, params: StopAllParams) -> list[str]:
    """Return the actuation components that are to be stopped: all of an engine, also those out of scope.

    Raises:
        BadParameter: two engines are named, or might be.
        Unsupported: there is no such engine or component.
        OutOfResources: the application holds nothing that acts there.
    """
    if params.engine_id is not None and params.component_ref is not None:
        raise BadParameter("give either an engine_id or a component_ref, not both")
    profiles = app.host.engine.directory.component_profiles
    acting = [ref for ref, profile in profiles.items() if profile.function is ComponentFunction.ACTUATION]
    shown = app.engine.directory.component_profiles
    if app.principal.is_administrator:
        mine = {engine_of(ref) for ref in shown}
    else:
        mine = {engine_of(ref) for ref in acting if app.host.leases.model.holding.is_held(ref, app)}
    if params.engine_id is None and params.component_ref is None:
        return [ref for ref in acting if engine_of(ref) in mine]
    if params.component_ref is not None:
        app.engine.require(params.component_ref)
    engine_id = params.engine_id or engine_of(params.component_ref or "")
    if engine_id not in {engine_of(ref) for ref in shown}:
        raise Unsupported(f"there is no engine {engine_id[:200]!r}")
    if engine_id not in mine:
        raise OutOfResources(f"the application holds no actuation component of {engine_id}: bind one first")
    return [ref for ref in acting if engine_of(ref) == engine_id]
