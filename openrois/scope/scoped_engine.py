"""An engine as one principal sees it: every reference of its applications is looked up here, and nowhere else."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from openrois.aio.listeners import Listeners
from openrois.auth.principal import Principal
from openrois.contract import Client, ComponentBus, Extension, Fault
from openrois.engine.engine import Engine, leads_to
from openrois.engine.tree import Tree
from openrois.errors import NotResponding, TimedOut, Unsupported
from openrois.scope.filter import scoped_fault
from openrois.scope.views import ViewChange, Views
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile
from openrois.types.references import engine_of
from openrois.types.streams import HolderNotification, subject_of

__all__ = ["ScopedEngine"]


class ScopedEngine:
    """The part of an engine that is in the scope of a principal, and the way to it.

    What is out of scope is refused by the look-up that refuses what does not exist, with the same words.

    Args:
        engine: all there is.
        principal: whose scope it is.
        views: of the engine.
    """

    def __init__(self, engine: Engine, principal: Principal, views: Views) -> None:
        self._engine = engine
        self._principal = principal
        self._views = views
        self._changes: Listeners[ViewChange] = Listeners()
        self._view = views.enter(principal)
        self._stop_following = self._view.changes.add(self._changes.notify_all)

    def close(self) -> None:
        """Stop following the engine."""
        self._stop_following()
        self._views.leave(self._view)

    @property
    def tree(self) -> Tree[Any]:
        """What there is for the principal now."""
        return self._view.tree

    @property
    def components(self) -> Mapping[str, HRIComponentProfile]:
        """The profile of every component that there is for the principal now, by its reference."""
        return self._view.tree.components

    @property
    def engine_id(self) -> str:
        """The engine's name in its tree."""
        return self._engine.engine_id

    @property
    def principal(self) -> Principal:
        """The principal; another one may take its place at any time, and its scope holds at once."""
        return self._principal

    @principal.setter
    def principal(self, principal: Principal) -> None:
        former, is_other = self._view, principal.scope != self._principal.scope
        self._principal = principal
        if not is_other:
            return
        self._stop_following()
        self._view = self._views.enter(principal)
        self._stop_following = self._view.changes.add(self._changes.notify_all)
        visible = former.tree.directory != self._view.tree.directory
        gone = frozenset(former.tree.components.keys() - self._view.tree.components.keys())
        engine_ids = frozenset(former.tree.engine_ids | self._view.tree.engine_ids) if visible else frozenset[str]()
        self._views.leave(former)
        self._changes.notify_all(ViewChange(visible, engine_ids, gone))

    def on_change(self, listener: Callable[[ViewChange], None]) -> Callable[[], None]:
        """Call `listener`, which must not block, whenever the tree or the scope changes; return what ends that."""
        return self._changes.add(listener)

    def sees(self, component_ref: str) -> bool:
        """Tell whether a component is in scope, whether it exists or not."""
        return self._principal.sees(component_ref)

    def hides(self, component_ref: str) -> bool:
        """Tell whether a component exists and is out of scope: for the audit trail, never for an answer."""
        is_there, is_seen = component_ref in self._engine.components, self.sees(component_ref)
        return is_there and not is_seen

    def require(self, component_ref: str) -> HRIComponentProfile:
        """Return the profile of a component.

        Raises:
            Unsupported: it does not exist, or is out of scope.
        """
        profile = self.components.get(component_ref)
        if profile is None:
            raise Unsupported(f"there is no component {component_ref[:200]!r}")
        return profile

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
        self._require_engine(ref_or_id)
        return self._engine.route(ref_or_id)

    def _require_engine(self, ref_or_id: str) -> None:
        if not self.tree.has_engine(engine_of(ref_or_id)):
            raise Unsupported(f"there is no engine for {ref_or_id[:200]!r}")

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
