"""The Command interface of an application whose engines are at several gateways."""

import logging
from collections.abc import Mapping
from typing import Any, Final

from openrois.errors import BadParameter, EngineUnreachable, OutOfResources, Unsupported
from openrois.federation.destinations import command_ids, engine_named, engines_commanded, only_stops
from openrois.federation.routes import Routes, fitting
from openrois.interfaces.selection import found_by
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.types.codes import ReturnCode
from openrois.types.messages import ConditionParams, ReferenceResult, SearchResult
from openrois.types.references import engine_of

__all__ = ["CommandRoutes"]

_log = logging.getLogger(__name__)


class CommandRoutes:
    """Commands, their results, and components that are found by a condition.

    Args:
        routes: of the application.
    """

    def __init__(self, routes: Routes) -> None:
        self._routes = routes

    def methods(self) -> BoundMethods:
        """Return the methods."""
        return BoundMethods((_METHODS, self))

    async def _execute(self, params: dict[str, Any]) -> Any:
        name = "rois.command.execute"
        commands = command_ids(params)
        refs = {engine_of(ref): ref for ref in commands.values()}
        engine_ids = sorted(engines_commanded(params))
        gateways = {self._routes.gateway(engine_id, refs.get(engine_id)) for engine_id in engine_ids}
        if len(gateways) > 1:
            raise BadParameter(f"{', '.join(engine_ids)} are at different gateways: send a sequence to each of them")
        gateway_id = gateways.pop() if gateways else None
        elsewhere = self._routes.work if gateway_id is None else self._routes.app.commands
        for command_id in commands:
            if command_id in elsewhere:
                raise BadParameter(f"the command_id {command_id[:200]!r} is empty or taken")
        if gateway_id is None:
            return await self._routes.local[name](params)
        if not (is_urgent := only_stops(params)):
            self._routes.app.host.require_staying()
        # Opened before the commands are noted: it is no end of theirs that the gateway is not reached.
        await self._routes.subs.to(gateway_id)
        self._routes.work.begin(gateway_id, commands)
        is_accepted = False

        def note(result: Mapping[str, Any]) -> None:
            nonlocal is_accepted
            is_accepted = result.get("return_code") == ReturnCode.OK.value

        try:
            return await self._routes.ask_at(
                gateway_id, name, params, refs=commands.values(), urgent=is_urgent, accepted=note
            )
        finally:
            if not is_accepted:
                self._routes.work.give_up(commands)

    async def _set_parameter(self, params: dict[str, Any]) -> Any:
        name, component_ref = "rois.command.set_parameter", params.get("component_ref")
        gateway_id = self._routes.gateway(engine_named(name, params), component_ref)
        if gateway_id is not None:
            self._routes.app.host.require_staying()

        def note(result: Mapping[str, Any]) -> None:
            command_id = result.get("command_id")
            if result.get("return_code") == ReturnCode.OK.value and isinstance(command_id, str) and gateway_id:
                self._routes.work.begin(gateway_id, {command_id: str(component_ref)})

        return await self._routes.ask_at(gateway_id, name, params, accepted=note)

    async def _get_command_result(self, params: dict[str, Any]) -> Any:
        name, command_id = "rois.command.get_command_result", params.get("command_id")
        gateway_id = self._routes.work.gateway_of_command(command_id) if isinstance(command_id, str) else None
        return await self._routes.ask_at(gateway_id, name, params)

    async def _search(self, params: dict[str, Any]) -> Any:
        asked = fitting(ConditionParams, params)
        if asked is None:
            return await self._routes.local["rois.command.search"](params)
        return SearchResult(component_ref_list=tuple(found_by(self._routes.engine.tree, asked.condition)))

    async def _bind_any(self, params: dict[str, Any]) -> Any:
        """Bind one at the first gateway that has a free one, in the order in which the components are found."""
        name, asked = "rois.command.bind_any", fitting(ConditionParams, params)
        if asked is None:
            return await self._routes.local[name](params)
        refs = found_by(self._routes.engine.tree, asked.condition)
        if not refs:
            raise Unsupported("no component satisfies the condition")
        for gateway_id in dict.fromkeys(self._routes.gateway(engine_of(ref)) for ref in refs):
            if gateway_id is None:
                result, _, reply = await self._routes.ask_here(name, params)
                if result.return_code is ReturnCode.OK:
                    return reply
                continue
            try:
                sub = await self._routes.subs.to(gateway_id)
                found, _ = await sub.ask(name, params)
            except EngineUnreachable as error:
                _log.info("bind_any goes on elsewhere: %s", error)
                continue
            if found.get("return_code") == ReturnCode.OK.value:
                component_ref = str(found.get("component_ref"))
                sub.note_ref(component_ref)
                self._routes.work.note_held(component_ref, is_held=True)
                return ReferenceResult.read_newer(found)
        raise OutOfResources("every component that satisfies the condition is bound by another application")


_METHODS: Final[Mapping[str, SharedMethod]] = {
    "rois.command.set_parameter": CommandRoutes._set_parameter,
    "rois.command.execute": CommandRoutes._execute,
    "rois.command.search": CommandRoutes._search,
    "rois.command.bind_any": CommandRoutes._bind_any,
    "rois.command.get_command_result": CommandRoutes._get_command_result,
}
