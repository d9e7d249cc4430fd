"""The engine: a component bus made of component buses. Gateway and adapter are both one of these.

A reference is `<engine_id>/<name>` from the adapter to the application; the engine routes by the id that leads it and
never rewrites it. The ids of a tree are unique, so the tree has no cycle and a route no second choice.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois.aio.listeners import Listeners
from openrois.contract import (
    Client,
    ComponentBus,
    Directory,
    Extension,
    Fault,
    FaultSource,
    OnFault,
    Sink,
    ignore_fault,
)
from openrois.engine.faults import FaultMint
from openrois.engine.lost_components import LostComponents
from openrois.errors import BadParameter, NotResponding, TimedOut, Unsupported
from openrois.types.codes import ErrorType
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from openrois.types.references import engine_of, flaw_of_name
from openrois.types.streams import HolderNotification, subject_of

__all__ = ["Engine", "leads_to"]

_log = logging.getLogger(__name__)

AUTHORITY: Final = "OpenRoIS"
"""Gives the ids of engines of this product their meaning."""

MAX_DEPTH: Final = 8
"""How deep engines may stand below one another."""


@dataclass(slots=True)
class _Child:
    bus: ComponentBus
    directory: Directory
    own: bool


@dataclass(frozen=True, slots=True)
class _Subscription:
    bus: ComponentBus
    component_ref: str


class Engine:
    """An engine with a name of its own and any number of buses attached; itself a `ComponentBus`.

    A bus whose root has the engine's own id brings the engine's own components; every other is a sub-engine.

    Attributes:
        engine_id: the engine's name in its tree.
        faults: gets the faults of the engine and of every bus attached to it.
        on_fault: the engine that this one is attached to gets them, too.
        mint: makes the faults that this engine notices.
        lost: components whose bus was lost.
    """

    def __init__(self, engine_id: str) -> None:
        if flaw := flaw_of_name(engine_id):
            raise BadParameter(f"{engine_id!r} is no engine id: {flaw}")
        self.engine_id = engine_id
        self.faults: Listeners[Fault] = Listeners()
        self.on_fault: OnFault = ignore_fault
        self.lost = LostComponents()
        self._children: list[_Child] = []
        self._routes: dict[str, ComponentBus] = {}
        self._subscriptions: dict[str, _Subscription] = {}
        self._changes: Listeners[()] = Listeners()
        self.mint = FaultMint(engine_id)
        self._directory = self._merge()

    async def attach(self, bus: ComponentBus, *, own: bool = True) -> None:
        """Add a bus and notify the listeners.

        Args:
            bus: what to add.
            own: whether it may bring the engine's own components, which a remote engine may not.

        Raises:
            BadParameter: its profile is broken, names an id that the tree has already (a cycle is that too), or
                stands too deep. Nothing was added.
            RoISError: it could not be asked.
        """
        if bus is self:
            raise BadParameter("an engine cannot be attached below itself")
        child = _Child(bus, await bus.discover(), own)
        self._check(child.directory, child)
        self._children.append(child)
        if isinstance(bus, FaultSource):
            bus.on_fault = self._notify_fault
        self._changed()

    async def refresh(self, bus: ComponentBus) -> None:
        """Read again what an attached bus offers and notify the listeners; a bus that is not attached is ignored.

        Raises:
            BadParameter: the new profile is not acceptable; the old one still stands.
            RoISError: it could not be asked.
        """
        directory = await bus.discover()
        child = next((child for child in self._children if child.bus is bus), None)
        if child is not None:
            self._check(directory, child)
            child.directory = directory
            self._changed()

    def detach(self, bus: ComponentBus, *, lost: str = "") -> None:
        """Remove a bus and notify the listeners; a bus that is not attached is ignored.

        Args:
            bus: what to take away.
            lost: why, where its connection was lost: applications that work with its components are notified that it
                does not respond, and until it is back its components count as failing.
        """
        leaving = [child for child in self._children if child.bus is bus]
        if leaving:
            gone = leaving[0].directory.profile.component_refs() if lost else ()
            self.lost.lose(gone)
            for fault in self.mint.make_each(ErrorType.COMPONENT_NOT_RESPONDING, gone, lost) if lost else ():
                self._notify_fault(fault)
            self._children.remove(leaving[0])
            if isinstance(bus, FaultSource):
                bus.on_fault = ignore_fault
            self._changed()

    def on_change(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call `listener`, which must not block, whenever the tree changes; return what ends that."""
        return self._changes.add(listener)

    def report(self, error_type: ErrorType, description: str, component_ref: str = "") -> None:
        """Report a fault that this engine noticed: its own, or that of a component which it called."""
        fault = self.mint.make(error_type, component_ref, description)
        if fault is not None:
            self._notify_fault(fault)

    def _notify_fault(self, fault: Fault) -> None:
        self.faults.notify_all(fault)
        self.on_fault(fault)

    def _check(self, directory: Directory, child: _Child) -> None:
        ids = directory.profile.engine_ids()
        own = child.own and ids == (self.engine_id,)
        taken = set() if own else {self.engine_id}
        for other in self._children:
            if other is not child:
                taken.update(other.directory.profile.engine_ids())
        for engine_id in ids:
            if flaw := flaw_of_name(engine_id):
                raise BadParameter(f"{engine_id[:200]!r} is no engine id: {flaw}")
            if engine_id in taken:
                raise BadParameter(f"the engine id {engine_id!r} is taken already: each engine needs one of its own")
            taken.add(engine_id)
        if _depth(directory.profile) >= MAX_DEPTH:
            raise BadParameter(f"engines may be nested {MAX_DEPTH} deep at most")
        offering, repeated = frozenset(ids), frozenset(directory.profile.repeated_refs())
        for ref in directory.profile.component_refs():
            if flaw := _flaw_of(ref, offering, directory) or ("it stands twice" if ref in repeated else ""):
                raise BadParameter(f"the component {ref[:300]!r} cannot be in this tree: {flaw}")

    def _changed(self) -> None:
        self._directory = self._merge()
        self.lost.found(self._directory.component_profiles)
        self._routes = {
            engine_id: child.bus for child in self._children for engine_id in child.directory.profile.engine_ids()
        }
        self._subscriptions = {
            subscribe_id: subscription
            for subscribe_id, subscription in self._subscriptions.items()
            if subscription.component_ref in self._directory.component_profiles
            and self._routes.get(engine_of(subscription.component_ref)) is subscription.bus
        }
        self._changes.notify_all()

    def _merge(self) -> Directory:
        own = [c.directory for c in self._children if c.directory.profile.identifier.code == self.engine_id]
        below = [c.directory for c in self._children if c.directory.profile.identifier.code != self.engine_id]
        profile = HRIEngineProfile(
            identifier=RoISIdentifier(code=self.engine_id, authority=AUTHORITY),
            sub_profiles=tuple(directory.profile for directory in below),
            component_ids=tuple(ref for directory in own for ref in directory.profile.component_ids),
        ).completed()
        # A bus speaks for the components it lists; another profile beside them could belong to another engine.
        components = {
            ref: directory.component_profiles[ref]
            for directory in (*own, *below)
            for ref in directory.profile.component_refs()
        }
        return Directory(profile, components)

    @property
    def directory(self) -> Directory:
        """The directory of the tree."""
        return self._directory

    async def discover(self) -> Directory:
        """Return the directory of the tree."""
        return self._directory

    def route(self, ref_or_id: str) -> ComponentBus:
        """Return the bus behind which the engine stands that leads `ref_or_id`.

        Raises:
            Unsupported: no such engine is in the tree.
        """
        bus = self._routes.get(engine_of(ref_or_id))
        if bus is None:
            raise Unsupported(f"there is no engine for {ref_or_id[:200]!r}")
        return bus

    def leads_alike(self, one: str, other: str) -> bool:
        """Tell whether two references or ids lead to the same bus."""
        buses = self._routes.get(engine_of(one)), self._routes.get(engine_of(other))
        return buses[0] is not None and buses[0] is buses[1]

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        """Query a component of the tree."""
        try:
            return await self.route(component_ref).query(component_ref, query_type)
        except NotResponding as silence:
            raise self.blame(component_ref, silence) from None

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        """Run a command of a component of the tree to its end."""
        try:
            return await self.route(component_ref).invoke(component_ref, command_type, arguments, command_id)
        except NotResponding as silence:
            raise self.blame(component_ref, silence) from None

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        """Subscribe to a component of the tree."""
        bus = self.route(component_ref)
        try:
            subscribe_id = await bus.subscribe(component_ref, event_type, sink)
        except NotResponding as silence:
            raise self.blame(component_ref, silence) from None
        self._subscriptions[subscribe_id] = _Subscription(bus, component_ref)
        return subscribe_id

    async def unsubscribe(self, subscribe_id: str) -> None:
        """End a subscription."""
        subscription = self._subscriptions.pop(subscribe_id, None)
        if subscription is not None:
            await subscription.bus.unsubscribe(subscribe_id)

    def blame(self, component_ref: str, silence: NotResponding) -> TimedOut:
        """Report that a call to a component had no answer; return what to raise, which is not reported again."""
        self.report(ErrorType.COMPONENT_NOT_RESPONDING, str(silence), component_ref)
        return TimedOut(str(silence))

    @property
    def extension(self) -> Extension:
        """The streaming and signaling methods of the whole tree, routed by the id or reference in their params."""
        return _TreeExtension(self)

    def extensions(self) -> tuple[Extension, ...]:
        """Return the extensions of the buses attached here that have one."""
        found = (getattr(child.bus, "extension", None) for child in self._children)
        return tuple(extension for extension in found if extension is not None)


def leads_to(engine: Engine, ref_or_id: str, bus: ComponentBus) -> bool:
    """Tell whether a reference or id still leads to `bus`, and not to another one or nowhere."""
    try:
        return engine.route(ref_or_id) is bus
    except Unsupported:
        return False


def _flaw_of(ref: str, engine_ids: frozenset[str], directory: Directory) -> str:
    """Return what is wrong with a component that an engine offers; empty where nothing is."""
    engine_id, _, name = ref.partition("/")
    if engine_id not in engine_ids:
        return "it does not begin with the id of an engine that offers it"
    return flaw_of_name(name) or ("" if ref in directory.component_profiles else "it has no profile")


def _depth(profile: HRIEngineProfile) -> int:
    return 1 + max((_depth(below) for below in profile.sub_profiles), default=0)


@dataclass(frozen=True, slots=True)
class _TreeExtension:
    """The extension of an engine: finds the bus an extension call is for."""

    engine: Engine

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines of the tree that have streams."""
        return frozenset[str]().union(*(extension.engines() for extension in self.engine.extensions()))

    def _of(self, subject: str) -> Extension:
        engine_id = engine_of(subject)
        for extension in self.engine.extensions():
            if engine_id in extension.engines():
                return extension
        raise Unsupported(f"there is no engine with streams for {subject[:200]!r}")

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Pass a call to the engine named by its component_ref, stream_id or peer_id."""
        extension = self._of(subject_of(params))
        try:
            return await extension.call(method, params, client)
        except NotResponding as silence:
            component_ref = params.get("component_ref")
            if not isinstance(component_ref, str):
                raise
            raise self.engine.blame(component_ref, silence) from None

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Notify the engine of the component, whether or not it has streams."""
        component_ref = notification.component_ref
        extension: Extension | None = getattr(self.engine.route(component_ref), "extension", None)
        if extension is None:
            raise Unsupported(f"the engine of {component_ref[:200]!r} takes no notification of holders")
        await extension.set_holder(notification, client)

    async def forget_client(self, client: Client) -> None:
        """End what a client has at every bus; one that fails does not keep the others from being called."""
        told = (extension.forget_client(client) for extension in self.engine.extensions())
        for outcome in await asyncio.gather(*told, return_exceptions=True):
            if isinstance(outcome, Exception):
                _log.info("an engine could not end what a departed client has: %s", outcome)
