"""The directory of a tree of engines, kept as buses come, change and go: each change costs what changed. Pure."""

from bisect import bisect_left, bisect_right, insort
from collections.abc import Collection, Iterable, Iterator, KeysView, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, Generic, TypeVar

from openrois.contract import Directory
from openrois.engine.component_index import ComponentIndex
from openrois.engine.condition import Condition
from openrois.engine.offers import ComparedOffers, Place, compare_offers
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier
from openrois.types.references import engine_of

__all__ = ["AUTHORITY", "Tree", "TreeChange"]

AUTHORITY: Final = "OpenRoIS"
"""Gives the ids of engines of this product their meaning."""

Bus = TypeVar("Bus")


@dataclass(frozen=True, eq=False)
class TreeChange:
    """One bus has come, offers something else, or has gone.

    Attributes:
        bus: which one.
        former: its offer before; None where it was not there.
        latter: its offer now; None where it is gone.
        engines_before: the engines of its former offer that may be others now, or are gone.
        engines_now: the engines of its offer that are new or may be others.
        gone_refs: the components that are not there any more.
        refs_now: the components of `engines_now`.
    """

    bus: Any
    former: Directory | None
    latter: Directory | None
    engines_before: frozenset[str]
    engines_now: frozenset[str]
    gone_refs: frozenset[str]
    refs_now: tuple[str, ...]

    @property
    def engine_ids(self) -> frozenset[str]:
        """The ids of all engines that the change may be about.

        What is as it was is among them: of engines behind another one, one may have left and come back meanwhile.
        """
        return self.engines_before | self.engines_now


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

    def compare(self, bus: Bus, profile: HRIEngineProfile) -> ComparedOffers:
        """Compare what a bus offers now with what it offered before."""
        former = self._offers.get(bus)
        return compare_offers(self.engine_id, None if former is None else former.profile, profile)

    def replace(self, bus: Bus, latter: Directory | None, compared: ComparedOffers | None = None) -> TreeChange:
        """Set what a bus offers, and return the change.

        Args:
            bus: which one.
            latter: its offer, of which only components that it lists count; None: it has gone.
            compared: how its profile differs from the former offer's; it is found out unless given.
        """
        former = self._offers.get(bus)
        if latter is None:
            self._offers.pop(bus, None)
            before = frozenset(() if former is None else former.profile.engine_ids())
            now: Mapping[str, Place] = {}
        else:
            compared = compared or self.compare(bus, latter.profile)
            profile, before, now = compared.profile, compared.before, compared.now
            latter = self._offers[bus] = Directory(
                profile, {ref: latter.component_profiles[ref] for ref in profile.component_ids}
            )
        gone = before - now.keys()
        refs_before = frozenset(ref for engine_id in before for ref in self._places[engine_id].component_refs)
        for engine_id in gone:
            del self._buses[engine_id]
            del self._places[engine_id]
        self._buses.update(dict.fromkeys(now, bus))
        self._places.update(now)
        self._sort(gone, now.keys() - before)
        refs_now = tuple(ref for place in now.values() for ref in place.component_refs)
        gone_refs = refs_before.difference(refs_now)
        self._replace_components(gone_refs, {} if latter is None else latter.component_profiles)
        self._directory = None
        return TreeChange(bus, former, latter, before, frozenset(now), gone_refs, refs_now)

    def _sort(self, gone: AbstractSet[str], came: AbstractSet[str]) -> None:
        """Keep the order of the ids, once it was asked for."""
        if self._sorted is None:
            return
        for engine_id in gone - {self.engine_id}:
            del self._sorted[bisect_left(self._sorted, engine_id)]
        for engine_id in came - {self.engine_id}:
            insort(self._sorted, engine_id)

    def _replace_components(self, gone_refs: Iterable[str], offered: Mapping[str, HRIComponentProfile]) -> None:
        for ref in gone_refs:
            self._index.remove(ref, self._components.pop(ref))
        for ref, profile in offered.items():
            known = self._components.get(ref)
            if known is profile:
                continue
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


def _listed(offers: Iterable[Directory]) -> Iterator[str]:
    return (ref for offer in offers for ref in offer.profile.component_ids)


def _restricted(profile: HRIEngineProfile, kept: AbstractSet[str]) -> HRIEngineProfile:
    below = (_restricted(sub_profile, kept) for sub_profile in profile.sub_profiles)
    return HRIEngineProfile(
        identifier=profile.identifier,
        sub_profiles=tuple(sub_profile for sub_profile in below if sub_profile.component_ids),
        component_ids=tuple(ref for ref in profile.component_ids if ref in kept),
        parameter_profiles=profile.parameter_profiles,
    )
