"""The System interface of an application whose engines are at several gateways."""

import logging
from asyncio import gather
from collections.abc import Mapping
from typing import Any, Final

from openrois.errors import RoISError
from openrois.federation.routes import Routes, fitting
from openrois.federation.sub_session import SubSession
from openrois.interfaces.system import profile_of
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.session.change_notice import ChangeNotice
from openrois.types.codes import ReturnCode
from openrois.types.directory import DIRECTORY
from openrois.types.messages import ConditionParams
from openrois.types.references import engine_of
from openrois.types.streams import HelloParams, HelloResult

__all__ = ["SystemRoutes"]

_log = logging.getLogger(__name__)

LEAVING_TIMEOUT: Final = 1.0
"""Seconds that another gateway has to confirm that an application has disconnected."""


class SystemRoutes:
    """What is about all engines of an application together.

    Args:
        routes: of the application.
        notice: notifies it of changes of the directory.
    """

    def __init__(self, routes: Routes, notice: ChangeNotice) -> None:
        self._routes = routes
        self._notice = notice

    def methods(self) -> BoundMethods:
        """Return the methods."""
        return BoundMethods((_METHODS, self))

    async def _hello(self, params: dict[str, Any]) -> Any:
        result, _, said = await self._routes.ask_here("openrois.hello", params)
        if not isinstance(result, HelloResult) or result.return_code is not ReturnCode.OK:
            return said
        await self._routes.subs.say("openrois.hello", params)
        if DIRECTORY in HelloParams.model_validate(params).extensions:
            self._notice.name_engines()
            return result
        seen = self._routes.federation.directory.streaming & self._routes.engine.tree.engine_ids
        return result.model_copy(update={"engines": tuple(sorted(seen))})

    async def _connect(self, params: dict[str, Any]) -> Any:
        await self._routes.subs.say("rois.system.connect", {})
        return await self._routes.local["rois.system.connect"](params)

    async def _disconnect(self, params: dict[str, Any]) -> Any:
        self._routes.subs.unsay("rois.system.connect")

        async def leave(sub: SubSession) -> None:
            try:
                await sub.ask("rois.system.disconnect", {}, timeout=LEAVING_TIMEOUT, urgent=True)
            except RoISError as error:
                # What it had there ends as that of a lost connection.
                _log.info("an application could not leave in good order: %s", error)
                sub.abort()

        await gather(*(leave(sub) for sub in self._routes.subs.open))
        return await self._routes.local["rois.system.disconnect"](params)

    async def _get_profile(self, params: dict[str, Any]) -> Any:
        asked = fitting(ConditionParams, params)
        if asked is None:
            return await self._routes.local["rois.system.get_profile"](params)
        self._routes.require_reachable(asked.condition)
        self._notice.flush()
        return profile_of(self._routes.engine.tree, asked)

    async def _get_error_detail(self, params: dict[str, Any]) -> Any:
        name, error_id = "rois.system.get_error_detail", params.get("error_id")
        engine_id = engine_of(error_id) if isinstance(error_id, str) else ""
        gateway_id = self._routes.gateway(engine_id)
        if gateway_id is not None:
            return await self._routes.ask_at(gateway_id, name, params)
        result, _, reply = await self._routes.ask_here(name, params)
        if engine_id != self._routes.engine.tree.engine_id or result.return_code is ReturnCode.OK:
            return reply
        for sub in self._routes.subs.open:
            # A fault of the main engine may have been noticed by any gateway.
            found, _ = await sub.ask(name, params)
            if found.get("return_code") == ReturnCode.OK.value:
                return found
        return reply


_METHODS: Final[Mapping[str, SharedMethod]] = {
    "rois.system.connect": SystemRoutes._connect,
    "rois.system.disconnect": SystemRoutes._disconnect,
    "rois.system.get_profile": SystemRoutes._get_profile,
    "rois.system.get_error_detail": SystemRoutes._get_error_detail,
    "openrois.hello": SystemRoutes._hello,
}
