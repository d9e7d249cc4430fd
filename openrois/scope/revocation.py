"""Losses of an application whose principal gets a smaller scope, or fewer roles, than before."""

import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from openrois.auth.principal import Principal
from openrois.contract import Client
from openrois.engine.engine import Engine
from openrois.errors import RoISError
from openrois.types.streams import STREAM_METHODS

__all__ = ["Entitlements", "end_streams"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Entitlements:
    """Entitlements of a principal: nothing that it could not get now."""

    principal: Principal

    def _may(self, method: str, component_ref: str) -> bool:
        return self.principal.may_call(method) and self.principal.sees(component_ref)

    def lost_bindings(self, bound: Iterable[str]) -> list[str]:
        """Return the components that it may not have bound."""
        return [ref for ref in bound if not self._may("rois.command.bind", ref)]

    def lost_streams(self, streams: Mapping[str, str]) -> list[str]:
        """Return the ids of the streams that it may not have; the component_ref of each is given."""
        return [stream_id for stream_id, ref in streams.items() if not self._may(STREAM_METHODS["connect_stream"], ref)]

    def loses_subscription(self, component_ref: str) -> bool:
        """Tell whether it may not be subscribed to events of a component."""
        return not self._may("rois.event.subscribe", component_ref)


async def end_streams(engine: Engine, stream_ids: Iterable[str], client: Client) -> None:
    """End streams of an application at their engines; an engine that does not answer ends them with the connection."""
    for stream_id in stream_ids:
        try:
            await engine.extension.call(STREAM_METHODS["disconnect_stream"], {"stream_id": stream_id}, client)
        except RoISError as error:
            _log.warning("a stream that its application lost could not be ended: %s", error)
