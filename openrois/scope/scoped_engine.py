"""An engine as one principal sees it: what its applications ask reaches what is in scope, and nothing else."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from openrois.auth.principal import Principal
from openrois.contract import Client, ComponentBus, Extension, Fault
from openrois.engine.engine import Engine, leads_to
from openrois.errors import NotResponding, TimedOut
from openrois.scope.filter import scoped_fault
from openrois.scope.scoped_tree import ScopedTree
from openrois.scope.views import Views
from openrois.types.messages import Argument, Result
from openrois.types.streams import HolderNotification, subject_of

__all__ = ["ScopedEngine"]


class ScopedEngine(ScopedTree):
    """The part of an engine that is in the scope of a principal, and the way to it.

    Args:
        engine: all there is.
        principal: whose scope it is.
        views: of the engine.
    """

    def __init__(self, engine: Engine, principal: Principal, views: Views) -> None:
        super().__init__(engine, principal, views)
        self._engine = engine

    @property
    def engine_id(self) -> str:
        """The engine's name in its tree."""
        return self._engine.engine_id

    def has_lost(self, component_ref: str | None) -> bool:
        """Tell whether a component is in scope whose engine was lost."""
        return component_ref is not None and component_ref in self._engine.lost and self.sees(component_ref)

    def scoped_fault(self, fault: Fault) -> Fault | None:
        """Return a fault as the principal may see it, None where it may not."""
        return scoped_fault(fault, self._engine.tree, self.tree, self._principal)

    def route(self, ref_or_id: str) -> ComponentBus:
        """Return the bus behind which the engine stands that leads `ref_or_id`.

        Raises:
            Unsupported: there is no such engine.
        """
        self.require_engine(ref_or_id)
        return self._engine.route(ref_or_id)

    def leads_alike(self, one: str, other: str) -> bool:
        """Tell whether two references or ids lead to the same bus."""
        return self._engine.leads_alike(one, other)

    def leads_to(self, component_ref: str, bus: ComponentBus) -> bool:
        """Tell whether a component is still in scope, and behind `bus`."""
        return component_ref in self.components and leads_to(self._engine, component_ref, bus)

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        """Query a component."""
        self.require(component_ref)
        return await self._engine.query(component_ref, query_type)

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        """Run a command of a component to its end."""
        self.require(component_ref)
        return await self._engine.invoke(component_ref, command_type, arguments, command_id)

    def blame(self, component_ref: str, silence: NotResponding) -> TimedOut:
        """Report that a call to a component had no answer; return what to raise."""
        return self._engine.blame(component_ref, silence)

    def has_streams(self, engine_id: str) -> bool:
        """Tell whether an engine is in scope that has the streaming methods."""
        return self.tree.has_engine(engine_id) and self._engine.extension_at(engine_id) is not None

    @property
    def extension(self) -> Extension:
        """The streaming and signaling methods of the engines in scope."""
        return _VisibleExtension(self, self._engine.extension)


@dataclass(frozen=True, slots=True)
class _VisibleExtension:
    """The extension of the engines in scope."""

    visible: ScopedEngine
    extension: Extension

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines that have streams."""
        return self.extension.engines() & self.visible.tree.engine_ids

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Pass a call to the engine named by its component_ref, stream_id or peer_id."""
        if "component_ref" in params:
            self.visible.require(params["component_ref"])
        self.visible.route(subject_of(params))
        return await self.extension.call(method, params, client)

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Notify the engine of a component in scope."""
        self.visible.require(notification.component_ref)
        await self.extension.set_holder(notification, client)

    async def forget_client(self, client: Client) -> None:
        """End what a client has at every engine, also at those that were in its scope before."""
        await self.extension.forget_client(client)
