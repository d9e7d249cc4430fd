"""The directory of a tree of engines, kept as buses come, change and go: each change costs what changed. Pure."""

from bisect import bisect_left, bisect_right, insort
from collections.abc import Collection, Iterable, Iterator, KeysView, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Final, Generic, TypeVar

from openrois.contract import Directory
from openrois.engine.component_index import ComponentIndex
from openrois.engine.condition import Condition
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, ParameterProfile, RoISIdentifier
from openrois.types.references import engine_of

__all__ = ["AUTHORITY", "Place", "Tree", "TreeChange"]

AUTHORITY: Final = "OpenRoIS"
"""Gives the ids of engines of this product their meaning."""

Bus = TypeVar("Bus")


@dataclass(frozen=True, slots=True)
class Place:
    """The place of an engine in a tree.

    Attributes:
        parent_id: the engine right above it.
        component_refs: the components that it owns, and no engine below it.
        identifier: of its profile.
        parameter_profiles: of its profile.
    """

    parent_id: str
    component_refs: tuple[str, ...]
    identifier: RoISIdentifier
    parameter_profiles: tuple[ParameterProfile, ...] = ()


@dataclass(frozen=True, eq=False)
class TreeChange:
    """One bus has come, offers something else, or has gone.

    Attributes:
        bus: which one.
        former: its offer before; None where it was not there.
        latter: its offer now; None where it is gone.
    """

    bus: Any
    former: Directory | None
    latter: Directory | None

    @cached_property
    def gone_refs(self) -> frozenset[str]:
        """The components that are not there any more."""
        return frozenset(_refs(self.former) - _refs(self.latter))

    @cached_property
    def engines_before(self) -> frozenset[str]:
        """The ids of the engines behind the bus before."""
        return _engines(self.former)

    @cached_property
    def engines_now(self) -> frozenset[str]:
        """The ids of the engines behind the bus now."""
        return _engines(self.latter)

    @property
    def engine_ids(self) -> frozenset[str]:
        """The ids of all engines that the change may be about.

        What is as it was is among them: of engines behind another one, one may have left and come back meanwhile.
        """
        return self.engines_before | self.engines_now


def _refs(offer: Directory | None) -> AbstractSet[str]:
    return frozenset() if offer is None else offer.component_profiles.keys()


def _engines(offer: Directory | None) -> frozenset[str]:
    return frozenset() if offer is None else frozenset(offer.profile.engine_ids())


class Tree(Generic[Bus]):
    """The offers of an engine's buses, as one directory.

    A bus whose root has the engine's own id brings the engine's own components; every other is a sub-engine.

    Args:
        engine_id: of the engine at the root.

    Attributes:
        components: the profile of every component by its reference; it changes with the tree.
    """

    def __init__(self, engine_id: str) -> None:
        self.engine_id = engine_id
        self._identifier = RoISIdentifier(code=engine_id, authority=AUTHORITY)
        self._offers: dict[Bus, Directory] = {}
        self._buses: dict[str, Bus] = {}
        self._components: dict[str, HRIComponentProfile] = {}
        self.components: Mapping[str, HRIComponentProfile] = MappingProxyType(self._components)
        self._index = ComponentIndex()
        self._places: dict[str, Place] = {}
        self._sorted: list[str] | None = None
        self._directory: Directory | None = None

    @property
    def engine_ids(self) -> AbstractSet[str]:
        """The ids of all engines, the root's among them; a copy."""
        return {self.engine_id, *self._buses}

    @property
    def sub_engine_ids(self) -> list[str]:
        """The ids of the engines right below the root, in the order in which they came."""
        roots = (offer.profile.identifier.code for offer in self._offers.values())
        return [engine_id for engine_id in roots if engine_id != self.engine_id]

    def has_engine(self, engine_id: str) -> bool:
        """Tell whether an engine is in the tree."""
        return engine_id == self.engine_id or engine_id in self._buses

    def bus_of(self, engine_id: str) -> Bus | None:
        """Return the bus behind which an engine stands; None where there is none."""
        return self._buses.get(engine_id)

    def offer_of(self, bus: Bus) -> Directory | None:
        """Return what a bus offers; None where it is not in the tree."""
        return self._offers.get(bus)

    def buses(self) -> KeysView[Bus]:
        """Return the buses in the order in which they came."""
        return self._offers.keys()

    def refs_of(self, engine_id: str) -> Collection[str]:
        """Return the components whose references an engine leads."""
        return self._index.refs_of(engine_id)

    def replace(self, bus: Bus, latter: Directory | None) -> TreeChange:
        """Set what a bus offers, and return the change.

        Args:
            bus: which one.
            latter: its offer, of which only components that it lists count; None: it has gone.
        """
        former = self._offers.get(bus)
        if latter is None:
            self._offers.pop(bus, None)
        else:
            latter = self._offers[bus] = _completed(latter)
        change = TreeChange(bus, former, latter)
        for engine_id in change.engines_before - change.engines_now:
            del self._buses[engine_id]
            del self._places[engine_id]
        self._buses.update(dict.fromkeys(change.engines_now, bus))
        self._places.update(() if latter is None else _places(latter.profile, self.engine_id))
        self._sort(change)
        self._replace_components(change)
        self._directory = None
        return change

    def _sort(self, change: TreeChange) -> None:
        """Keep the order of the ids, once it was asked for."""
        if self._sorted is None:
            return
        for engine_id in change.engines_before - change.engines_now - {self.engine_id}:
            del self._sorted[bisect_left(self._sorted, engine_id)]
        for engine_id in change.engines_now - change.engines_before - {self.engine_id}:
            insort(self._sorted, engine_id)

    def _replace_components(self, change: TreeChange) -> None:
        for ref in change.gone_refs:
            self._index.remove(ref, self._components.pop(ref))
        for ref, profile in () if change.latter is None else change.latter.component_profiles.items():
            known = self._components.get(ref)
            if known is not None and known.component_type != profile.component_type:
                self._index.remove(ref, known)
                known = None
            self._components[ref] = profile
            if known is None:
                self._index.add(ref, profile)

    def place_of(self, engine_id: str) -> Place | None:
        """Return the place of an engine; None where it is not in the tree."""
        if engine_id == self.engine_id:
            own = self._places.get(engine_id)
            return Place("", () if own is None else own.component_refs, self._identifier)
        return self._places.get(engine_id)

    def engines_after(self, engine_id: str) -> Iterator[str]:
        """Yield the engines whose ids come behind one, in their order; the tree must not change meanwhile."""
        if self._sorted is None:
            self._sorted = sorted(self.engine_ids)
        for number in range(bisect_right(self._sorted, engine_id), len(self._sorted)):
            yield self._sorted[number]

    @property
    def engine_count(self) -> int:
        """How many engines there are, the root among them."""
        return len(self._buses) + (self.engine_id not in self._buses)

    def search(self, condition: Condition) -> list[str]:
        """Return the references of the components that satisfy a condition, in the order in which they came."""
        return self._index.search(condition)

    @property
    def directory(self) -> Directory:
        """The whole directory, the engine's own components first; made when it is asked for, once for each change."""
        if self._directory is None:
            self._directory = self._merged(self._offers.values())
        return self._directory

    def restricted(self, refs: Iterable[str]) -> HRIEngineProfile:
        """Return the tree of engines with only these components; sub-engines without any are left out."""
        kept = set(refs)
        buses = dict.fromkeys(self._buses[engine_id] for engine_id in map(engine_of, kept) if engine_id in self._buses)
        offers = (offer for bus in self._in_order(buses) if (offer := self._offers.get(bus)) is not None)
        return _restricted(self._merged(offers).profile, kept)

    def _in_order(self, buses: Collection[Bus]) -> Iterator[Bus]:
        return iter(buses) if len(buses) <= 1 else (bus for bus in self._offers if bus in buses)

    def _merged(self, offers: Iterable[Directory]) -> Directory:
        own, below = list[Directory](), list[Directory]()
        for offer in offers:
            (own if offer.profile.identifier.code == self.engine_id else below).append(offer)
        refs = (*_listed(own), *_listed(below))
        profile = HRIEngineProfile(
            identifier=self._identifier,
            sub_profiles=tuple(offer.profile for offer in below),
            component_ids=refs,
        )
        return Directory(profile, {ref: self._components[ref] for ref in refs})


def _places(profile: HRIEngineProfile, root_id: str) -> Iterator[tuple[str, Place]]:
    """Yield the place of each engine of an offer below an engine."""
    engine_id = profile.identifier.code
    yield engine_id, Place(root_id, profile.own_refs(), profile.identifier, profile.parameter_profiles)
    for below in profile.sub_profiles:
        yield from _places(below, engine_id)


def _listed(offers: Iterable[Directory]) -> Iterator[str]:
    return (ref for offer in offers for ref in offer.profile.component_ids)


def _completed(offer: Directory) -> Directory:
    """Return an offer with, at every level, all that is reachable through that engine, and nothing that none lists."""
    profile = offer.profile.completed()
    return Directory(profile, {ref: offer.component_profiles[ref] for ref in profile.component_ids})


def _restricted(profile: HRIEngineProfile, kept: AbstractSet[str]) -> HRIEngineProfile:
    below = (_restricted(sub_profile, kept) for sub_profile in profile.sub_profiles)
    return HRIEngineProfile(
        identifier=profile.identifier,
        sub_profiles=tuple(sub_profile for sub_profile in below if sub_profile.component_ids),
        component_ids=tuple(ref for ref in profile.component_ids if ref in kept),
        parameter_profiles=profile.parameter_profiles,
    )
