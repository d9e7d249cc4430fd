"""The engine: a component bus made of component buses. Gateway and adapter are both one of these.

A reference is `<engine_id>/<name>` from the adapter to the application; the engine routes by the id that leads it and
never rewrites it. The ids of a tree are unique, so the tree has no cycle and a route no second choice.
"""

import asyncio
import logging
from collections.abc import Callable, Iterator, Mapping
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
from openrois.engine.extension_users import ExtensionUsers
from openrois.engine.faults import FaultMint
from openrois.engine.lost_components import LostComponents
from openrois.engine.offers import ComparedOffers
from openrois.engine.tree import Tree, TreeChange
from openrois.errors import BadParameter, NotResponding, TimedOut, Unsupported
from openrois.types.codes import ComponentFunction, ErrorType
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile
from openrois.types.references import engine_of, flaw_of_name
from openrois.types.streams import HolderNotification, subject_of

__all__ = ["Engine", "leads_to"]

_log = logging.getLogger(__name__)

MAX_DEPTH: Final = 8
"""How deep engines may stand below one another."""


class Engine:
    """An engine with a name of its own and any number of buses attached; itself a `ComponentBus`.

    A bus whose root has the engine's own id brings the engine's own components; every other is a sub-engine.

    Attributes:
        engine_id: the engine's name in its tree.
        tree: what its buses offer.
        users: which buses know which clients.
        changes: called with each change of the tree; they must not block.
        faults: gets the faults of the engine and of every bus attached to it; those of one cause together.
        on_fault: the engine that this one is attached to gets them, too.
        mint: makes the faults that this engine notices.
        lost: components whose bus was lost.
    """

    def __init__(self, engine_id: str) -> None:
        if flaw := flaw_of_name(engine_id):
            raise BadParameter(f"{engine_id!r} is no engine id: {flaw}")
        self.engine_id = engine_id
        self.faults: Listeners[tuple[Fault, ...]] = Listeners()
        self.on_fault: OnFault = ignore_fault
        self.lost = LostComponents()
        self.tree: Tree[ComponentBus] = Tree(engine_id)
        self.changes: Listeners[TreeChange] = Listeners()
        self.mint = FaultMint(engine_id)
        self._may_be_own: dict[ComponentBus, bool] = {}
        self._subscriptions: dict[str, str] = {}
        """The component of each subscription."""
        self._subscribed: dict[str, set[str]] = {}
        """The subscriptions of each component."""
        self.users = ExtensionUsers()

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
        directory = await bus.discover()
        compared = self.check(bus, directory, own=own)
        self._may_be_own[bus] = own
        if isinstance(bus, FaultSource):
            bus.on_fault = self._notify_fault
        self._replace(bus, directory, compared)

    async def refresh(self, bus: ComponentBus) -> frozenset[str]:
        """Read again what an attached bus offers and notify the listeners; a bus that is not attached is ignored.

        Returns:
            The components that it does not offer any more.

        Raises:
            BadParameter: the new profile is not acceptable; the old one still stands.
            RoISError: it could not be asked.
        """
        directory = await bus.discover()
        if self.tree.offer_of(bus) is None:
            return frozenset()
        compared = self.check(bus, directory, own=self._may_be_own[bus])
        return self._replace(bus, directory, compared)

    def detach(self, bus: ComponentBus, *, lost: str = "") -> frozenset[str]:
        """Remove a bus and notify the listeners; a bus that is not attached is ignored.

        Args:
            bus: what to take away.
            lost: why, where its connection was lost: applications that work with its components are notified that it
                does not respond, and until it is back its components count as failing.

        Returns:
            The components that it offered.
        """
        offer = self.tree.offer_of(bus)
        if offer is None:
            return frozenset()
        if lost:
            gone = offer.profile.component_ids
            self.lost.lose(gone)
            self._notify_faults(self.mint.make_each(ErrorType.COMPONENT_NOT_RESPONDING, gone, lost))
        del self._may_be_own[bus]
        if isinstance(bus, FaultSource):
            bus.on_fault = ignore_fault
        return self._replace(bus, None)

    def on_change(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call `listener`, which must not block, whenever the tree changes; return what ends that."""
        return self.changes.add(lambda _change: listener())

    def report(self, error_type: ErrorType, description: str, component_ref: str = "") -> None:
        """Report a fault that this engine noticed: its own, or that of a component which it called."""
        fault = self.mint.make(error_type, component_ref, description)
        if fault is not None:
            self._notify_fault(fault)

    def _notify_fault(self, fault: Fault) -> None:
        self._notify_faults((fault,))

    def _notify_faults(self, faults: tuple[Fault, ...]) -> None:
        """Notify of faults of one cause together: most of the thousands of sessions are not concerned."""
        self.faults.notify_all(faults)
        for fault in faults:
            self.on_fault(fault)

    def check(self, bus: ComponentBus, directory: Directory, *, own: bool) -> ComparedOffers:
        """Compare what a bus offers with its former offer, and check what is new, as `attach` does.

        Raises:
            BadParameter: it cannot be in this tree.
        """
        compared = self.tree.compare(bus, directory.profile)
        for engine_id in compared.now:
            if flaw := flaw_of_name(engine_id):
                raise BadParameter(f"{engine_id[:200]!r} is no engine id: {flaw}")
            is_own = own and engine_id == directory.profile.identifier.code and not directory.profile.sub_profiles
            is_ours = engine_id == self.engine_id and not is_own
            if is_ours or engine_id in compared.twice or self._is_taken(engine_id, bus, compared):
                raise BadParameter(f"the engine id {engine_id!r} is taken already: each engine needs one of its own")
        if _depth(directory.profile) >= MAX_DEPTH:
            raise BadParameter(f"engines may be nested {MAX_DEPTH} deep at most")
        for ref in self._refs_in_question(compared):
            if flaw := self._flaw_of(ref, bus, directory, compared):
                raise BadParameter(f"the component {ref[:300]!r} cannot be in this tree: {flaw}")
        return compared

    def _is_taken(self, engine_id: str, bus: ComponentBus, compared: ComparedOffers) -> bool:
        """Tell whether an engine of another bus has an id, or one of this bus that stays as it is."""
        there = self.tree.bus_of(engine_id)
        return there is not None and (there is not bus or engine_id not in compared.before)

    def _refs_in_question(self, compared: ComparedOffers) -> Iterator[str]:
        """Yield the components of an offer that are new, and those whose engine is not there any more."""
        for place in compared.now.values():
            yield from place.component_refs
        yield from compared.repeated
        places = (self.tree.place_of(engine_id) for engine_id in compared.before)
        before = {ref for place in places if place is not None for ref in place.component_refs}
        for engine_id in compared.before - compared.now.keys():
            yield from (ref for ref in self.tree.refs_of(engine_id) if ref not in before)

    def _flaw_of(self, ref: str, bus: ComponentBus, directory: Directory, compared: ComparedOffers) -> str:
        """Return what is wrong with a component that a bus offers; empty where nothing is."""
        engine_id, _, name = ref.partition("/")
        stays = self.tree.bus_of(engine_id) is bus and engine_id not in compared.before
        if engine_id not in compared.now and not stays:
            return "it does not begin with the id of an engine that offers it"
        flaw = flaw_of_name(name) or ("" if ref in directory.component_profiles else "it has no profile")
        return flaw or ("it stands twice" if ref in compared.repeated else "")

    def _replace(
        self, bus: ComponentBus, directory: Directory | None, compared: ComparedOffers | None = None
    ) -> frozenset[str]:
        """Set what a bus offers, notify the listeners, and return the components that are not there any more."""
        change = self.tree.replace(bus, directory, compared)
        self.lost.found(change.refs_now)
        gone = change.gone_refs
        for ref in gone:
            for subscribe_id in self._subscribed.pop(ref, ()):
                del self._subscriptions[subscribe_id]
        self.changes.notify_all(change)
        return gone

    @property
    def components(self) -> Mapping[str, HRIComponentProfile]:
        """The profile of every component of the tree by its reference; it changes with the tree."""
        return self.tree.components

    @property
    def directory(self) -> Directory:
        """The directory of the tree."""
        return self.tree.directory

    async def discover(self) -> Directory:
        """Return the directory of the tree."""
        return self.tree.directory

    def route(self, ref_or_id: str) -> ComponentBus:
        """Return the bus behind which the engine stands that leads `ref_or_id`.

        Raises:
            Unsupported: no such engine is in the tree.
        """
        bus = self.tree.bus_of(engine_of(ref_or_id))
        if bus is None:
            raise Unsupported(f"there is no engine for {ref_or_id[:200]!r}")
        return bus

    def leads_alike(self, one: str, other: str) -> bool:
        """Tell whether two references or ids lead to the same bus."""
        buses = self.tree.bus_of(engine_of(one)), self.tree.bus_of(engine_of(other))
        return buses[0] is not None and buses[0] is buses[1]

    def acting_of(self, engine_id: str) -> list[str]:
        """Return the actuation components of one engine of the tree; none where there is no such engine."""
        refs = self.tree.refs_of(engine_id)
        return [ref for ref in refs if self.components[ref].function is ComponentFunction.ACTUATION]

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
        if leads_to(self, component_ref, bus):
            self._subscriptions[subscribe_id] = component_ref
            self._subscribed.setdefault(component_ref, set()).add(subscribe_id)
        return subscribe_id

    async def unsubscribe(self, subscribe_id: str) -> None:
        """End a subscription."""
        component_ref = self._subscriptions.pop(subscribe_id, None)
        if component_ref is None:
            return
        subscribed = self._subscribed[component_ref]
        subscribed.remove(subscribe_id)
        if not subscribed:
            del self._subscribed[component_ref]
        await self.route(component_ref).unsubscribe(subscribe_id)

    def blame(self, component_ref: str, silence: NotResponding) -> TimedOut:
        """Report that a call to a component had no answer; return what to raise, which is not reported again."""
        self.report(ErrorType.COMPONENT_NOT_RESPONDING, str(silence), component_ref)
        return TimedOut(str(silence))

    @property
    def extension(self) -> Extension:
        """The streaming and signaling methods of the whole tree, routed by the id or reference in their params."""
        return _TreeExtension(self)

    def extension_at(self, engine_id: str) -> Extension | None:
        """Return the extension of the bus behind which an engine with streams stands; None where it has none."""
        extension: Extension | None = getattr(self.tree.bus_of(engine_id), "extension", None)
        return extension if extension is not None and engine_id in extension.engines() else None


def leads_to(engine: Engine, ref_or_id: str, bus: ComponentBus) -> bool:
    """Tell whether a reference or id still leads to `bus`, and not to another one or nowhere."""
    try:
        return engine.route(ref_or_id) is bus
    except Unsupported:
        return False


def _depth(profile: HRIEngineProfile) -> int:
    return 1 + max((_depth(below) for below in profile.sub_profiles), default=0)


@dataclass(frozen=True, slots=True)
class _TreeExtension:
    """The extension of an engine: finds the bus an extension call is for."""

    engine: Engine

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines of the tree that have streams."""
        extensions = (getattr(bus, "extension", None) for bus in self.engine.tree.buses())
        return frozenset[str]().union(*(each.engines() for each in extensions if each is not None))

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Pass a call to the engine named by its component_ref, stream_id or peer_id."""
        subject = subject_of(params)
        extension = self.engine.extension_at(engine_of(subject))
        if extension is None:
            raise Unsupported(f"there is no engine with streams for {subject[:200]!r}")
        if "role" in params and not getattr(extension, "takes_role", False):
            # What is not known there is not asked: consent that is passed over would be none.
            raise Unsupported("the engine tells no visitors apart, and knows no consent: its adapter is too old")
        bus = self.engine.route(subject)
        self.engine.users.note(client, bus)
        try:
            return await extension.call(method, params, client)
        except NotResponding as silence:
            component_ref = params.get("component_ref")
            if not isinstance(component_ref, str):
                raise
            raise self.engine.blame(component_ref, silence) from None
        finally:
            # A client that was forgotten meanwhile may have something there now.
            self.engine.users.note(client, bus)

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Notify the engine of the component, whether or not it has streams."""
        component_ref = notification.component_ref
        bus = self.engine.route(component_ref)
        extension: Extension | None = getattr(bus, "extension", None)
        if extension is None:
            raise Unsupported(f"the engine of {component_ref[:200]!r} takes no notification of holders")
        self.engine.users.note(client, bus)
        await extension.set_holder(notification, client)

    async def forget_client(self, client: Client) -> None:
        """End what a client has at every bus; one that fails does not keep the others from being called."""
        extensions = (getattr(bus, "extension", None) for bus in self.engine.users.forget_client(client))
        told = (each.forget_client(client) for each in extensions if each is not None)
        for outcome in await asyncio.gather(*told, return_exceptions=True):
            if isinstance(outcome, Exception):
                _log.info("an engine could not end what a departed client has: %s", outcome)
