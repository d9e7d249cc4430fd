"""STOP of an application whose engines are at several gateways: by the link between these, and by the store too.

A body is handed back by the link alone: what comes by two ways comes twice, and the second one could hand back what
another person has stopped meanwhile. Where the link does not carry it, the person is told.
"""

import asyncio
from collections.abc import Iterable, Mapping
from typing import Any, Final

from pydantic import ValidationError

from openrois.errors import EngineUnreachable, NotResponding, OutOfResources
from openrois.federation.other_way import OtherWay
from openrois.federation.routes import Routes, fitting
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Reply
from openrois.types.codes import ComponentFunction, ReturnCode
from openrois.types.leases import StopAllParams, StopAllResult
from openrois.types.references import engine_of
from openrois.types.stops import ReleaseStopParams, new_stop_id

__all__ = ["StopRoutes"]

HEAD_START: Final = 0.15
"""Seconds that the link between gateways has before a STOP goes by the store as well: it may be lost unnoticed."""

_STOP: Final = "openrois.stop_all"
_RELEASE: Final = "openrois.lease.release_stop"


class StopRoutes:
    """`openrois.stop_all` and `openrois.lease.release_stop` of one application.

    Args:
        routes: of the application.
        other_way: beside the link.
    """

    def __init__(self, routes: Routes, other_way: OtherWay) -> None:
        self._routes = routes
        self._other_way = other_way

    def methods(self) -> BoundMethods:
        """Return the methods."""
        return BoundMethods((_METHODS, self))

    async def _stop_all(self, params: dict[str, Any]) -> Any:
        # By whichever ways it goes, and how often it comes: it is one STOP.
        params = {"stop_id": new_stop_id(), **params}
        routes, asked = self._routes, fitting(StopAllParams, params)
        if asked is None or (asked.engine_id is not None and asked.component_ref is not None):
            return await routes.local[_STOP](params)
        if asked.engine_id is None and asked.component_ref is None:
            return await self._stop_everything(params)
        engine_id = asked.engine_id or engine_of(asked.component_ref or "")
        if not self._may_see(engine_id, asked.component_ref):
            return await routes.local[_STOP](params)
        gateway_id = routes.federation.owner_of(engine_id)
        if gateway_id is None or gateway_id == routes.federation.gateway_id:
            return await routes.local[_STOP](params)
        result, reason = await self._stop_at(gateway_id, params, (engine_id,))
        return Reply(result, reason=reason)

    async def _release_stop(self, params: dict[str, Any]) -> Any:
        routes, asked = self._routes, fitting(ReleaseStopParams, params)
        if asked is None or (asked.engine_id is None) == (asked.component_ref is None):
            return await routes.local[_RELEASE](params)
        engine_id = asked.engine_id or engine_of(asked.component_ref or "")
        gateway_id = None
        try:
            if self._may_see(engine_id, asked.component_ref):
                gateway_id = routes.gateway(engine_id, asked.component_ref or f"{engine_id}/")
            return await routes.ask_at(gateway_id, _RELEASE, params)
        except (EngineUnreachable, NotResponding) as error:
            raise type(error)(f"{engine_id} may still be stopped for programs: {error}") from error

    def _may_see(self, engine_id: str, component_ref: str | None) -> bool:
        """Tell whether the application would see an engine or a component, whether its gateway is reached or not."""
        engine = self._routes.engine
        if component_ref is not None:
            return engine.sees(component_ref)
        return engine.tree.has_engine(engine_id) or engine.sees(f"{engine_id}/") or self._sees_acting(engine_id)

    def _sees_acting(self, engine_id: str) -> bool:
        """Tell whether something that acts on an engine is in scope; of a gateway that was lost what it had counts."""
        engine = self._routes.engine
        refs = engine.tree.refs_of(engine_id)
        if any(engine.components[ref].function is ComponentFunction.ACTUATION for ref in refs):
            return True
        lost = self._routes.federation.directory.lost_acting
        return any(engine_of(ref) == engine_id and engine.sees(ref) for ref in lost)

    async def _stop_everything(self, params: dict[str, Any]) -> Reply:
        """Stop what the application controls at each gateway; an administrator controls all that it sees."""
        routes = self._routes
        engines = {engine_of(ref) for ref in routes.work.held}
        if routes.app.principal.is_administrator:
            engines |= {engine_of(ref) for ref in routes.engine.components}
        by_gateway: dict[str, list[str]] = {}
        for engine_id in sorted(engines):
            gateway_id = routes.federation.owner_of(engine_id)
            if gateway_id is not None and gateway_id != routes.federation.gateway_id:
                by_gateway.setdefault(gateway_id, []).append(engine_id)

        async def stop_here() -> tuple[StopAllResult, str]:
            result, reason, _ = await routes.ask_here(_STOP, params)
            return result, reason

        stops = (self._stop_at(gateway_id, params, found) for gateway_id, found in by_gateway.items())
        outcomes = await asyncio.gather(stop_here(), *stops)
        return Reply(_together(result for result, _ in outcomes), reason="; ".join(why for _, why in outcomes if why))

    async def _stop_at(
        self, gateway_id: str, params: dict[str, Any], engine_ids: Iterable[str]
    ) -> tuple[StopAllResult, str]:
        """Stop engines of another gateway: by the link, and where that does not answer soon by the store too."""
        ways = [asyncio.ensure_future(self._by_link(gateway_id, params))]
        try:
            await asyncio.wait(ways, timeout=HEAD_START)
            if not _is_answered(ways[0]):
                ways.append(asyncio.ensure_future(self._by_store(gateway_id, engine_ids, params["stop_id"])))
            while not any(map(_is_answered, ways)) and (open_ways := [each for each in ways if not each.done()]):
                await asyncio.wait(open_ways, return_when=asyncio.FIRST_COMPLETED)
            answered = next(filter(_is_answered, ways), None)
            if answered is not None:
                return answered.result()
            reasons = "; ".join(dict.fromkeys(str(each.exception()) for each in ways))
            return StopAllResult(return_code=ReturnCode.ERROR), f"STOP has not reached gateway {gateway_id}: {reasons}"
        finally:
            for each in ways:
                each.cancel()
            await asyncio.gather(*ways, return_exceptions=True)

    async def _by_link(self, gateway_id: str, params: dict[str, Any]) -> tuple[StopAllResult, str]:
        sub = await self._routes.subs.to(gateway_id)
        result, reason = await sub.ask(_STOP, params, urgent=True)
        try:
            return StopAllResult.read_newer(result), reason
        except ValidationError:
            raise EngineUnreachable(f"gateway {gateway_id} answers STOP with what is no answer") from None

    async def _by_store(self, gateway_id: str, engine_ids: Iterable[str], stop_id: str) -> tuple[StopAllResult, str]:
        """Stop engines by the store; that something which acts there is in scope is found out here."""
        routes = self._routes
        asked = [each for each in engine_ids if self._may_stop(each)]
        if not asked:
            raise OutOfResources("whether the application may stop them is not known here")
        who = routes.app.principal
        answers = await asyncio.gather(
            *(self._other_way.ask(gateway_id, each, who.subject, rank=who.rank, stop_id=stop_id) for each in asked)
        )
        unanswered = [answer.problem for answer in answers if not answer.is_answered]
        if unanswered:
            raise EngineUnreachable("; ".join(dict.fromkeys(unanswered)))
        shown = routes.engine.sees
        results = [
            StopAllResult(
                return_code=ReturnCode.ERROR if answer.failed or answer.problem else ReturnCode.OK,
                stopped=tuple(ref for ref in answer.stopped if shown(ref)),
                failed=tuple(ref for ref in answer.failed if shown(ref)),
            )
            for answer in answers
        ]
        return _together(results), "; ".join(answer.problem for answer in answers if answer.problem)

    def _may_stop(self, engine_id: str) -> bool:
        routes = self._routes
        # This gateway may never have seen what an engine has whose gateway it does not reach.
        is_entrusted = routes.app.principal.is_administrator and routes.engine.sees(f"{engine_id}/")
        is_held = any(engine_of(ref) == engine_id for ref in routes.work.held)
        return is_entrusted or is_held or self._sees_acting(engine_id)


_METHODS: Final[Mapping[str, SharedMethod]] = {
    _STOP: StopRoutes._stop_all,
    _RELEASE: StopRoutes._release_stop,
}


def _is_answered(asked: "asyncio.Future[tuple[StopAllResult, str]]") -> bool:
    return asked.done() and not asked.cancelled() and asked.exception() is None


def _together(results: Iterable[StopAllResult]) -> StopAllResult:
    found = list(results)
    is_done = all(result.return_code is ReturnCode.OK for result in found)
    return StopAllResult(
        return_code=ReturnCode.OK if is_done else ReturnCode.ERROR,
        stopped=tuple(ref for result in found for ref in result.stopped),
        failed=tuple(ref for result in found for ref in result.failed),
    )
