"""The Command interface of an application whose engines are at several gateways."""

import logging
from collections.abc import Mapping
from typing import Any

from openrois.errors import BadParameter, EngineUnreachable, OutOfResources, Unsupported
from openrois.federation.destinations import command_ids, engine_named, engines_commanded, only_stops
from openrois.federation.routes import Routes, fitting
from openrois.interfaces.selection import found_by
from openrois.jsonrpc.session import Handler
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

    def methods(self) -> dict[str, Handler]:
        """Return the methods."""
        return {
            "rois.command.set_parameter": self._set_parameter,
            "rois.command.execute": self._execute,
            "rois.command.search": self._search,
            "rois.command.bind_any": self._bind_any,
            "rois.command.get_command_result": self._get_command_result,
        }

    async def _execute(self, params: dict[str, Any]) -> Any:
        name = "rois.command.execute"
        commands = command_ids(params)
        named = {engine_id: self._routes.gateway(engine_id) for engine_id in engines_commanded(params)}
        gateways = set(named.values())
        if len(gateways) > 1:
            engines = ", ".join(sorted(named))
            raise BadParameter(f"{engines} are at different gateways: send a sequence to each of them")
        for engine_id in named:
            self._routes.gateway(
                engine_id, next((ref for ref in commands.values() if engine_of(ref) == engine_id), None)
            )
        gateway_id = gateways.pop() if gateways else None
        if gateway_id is None:
            taken = next((each for each in commands if each in self._routes.work), None)
            if taken is not None:
                raise BadParameter(f"the command_id {taken[:200]!r} is empty or taken")
            return await self._routes.local[name](params)
        taken = next((each for each in commands if each in self._routes.app.commands), None)
        if taken is not None:
            raise BadParameter(f"the command_id {taken[:200]!r} is empty or taken")
        sub = await self._routes.subs.to(gateway_id)
        self._routes.work.begin(gateway_id, commands)
        is_accepted = False

        def note(result: Mapping[str, Any]) -> None:
            nonlocal is_accepted
            is_accepted = result.get("return_code") == ReturnCode.OK.value

        for ref in commands.values():
            sub.note_ref(ref)
        try:
            return await sub.relay(name, params, urgent=only_stops(params), accepted=note)
        finally:
            if not is_accepted:
                self._routes.work.give_up(commands)

    async def _set_parameter(self, params: dict[str, Any]) -> Any:
        name, component_ref = "rois.command.set_parameter", params.get("component_ref")
        sub = await self._routes.sub(engine_named(name, params), component_ref)
        if sub is None:
            return await self._routes.local[name](params)

        def note(result: Mapping[str, Any]) -> None:
            command_id = result.get("command_id")
            if result.get("return_code") == ReturnCode.OK.value and isinstance(command_id, str):
                self._routes.work.begin(sub.gateway_id, {command_id: str(component_ref)})

        return await sub.relay(name, params, accepted=note)

    async def _get_command_result(self, params: dict[str, Any]) -> Any:
        name, command_id = "rois.command.get_command_result", params.get("command_id")
        gateway_id = self._routes.work.gateway_of_command(command_id) if isinstance(command_id, str) else None
        if gateway_id is None:
            return await self._routes.local[name](params)
        return await (await self._routes.subs.to(gateway_id)).relay(name, params)

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
                return ReferenceResult.model_validate(found)
        raise OutOfResources("every component that satisfies the condition is bound by another application")
