"""What differs between two offers of a bus. Pure.

An engine's profile that is the same object as before stands for an engine that has neither changed nor left since, with
all below it: of thousands behind one bus only the others are looked at.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from openrois.types.profiles import HRIEngineProfile, ParameterProfile, RoISIdentifier

__all__ = ["ComparedOffers", "Place", "compare_offers"]


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


@dataclass(frozen=True, slots=True)
class ComparedOffers:
    """How an offer differs from the one before.

    Attributes:
        profile: the offer's, with all that is reachable through each engine at every level.
        before: the engines of the former offer that may be others now, or are gone.
        now: the engines of the offer that are new or may be others.
        twice: those of them that stand in the offer more than once.
        repeated: references that one engine lists twice, or two that do not stand below one another.
    """

    profile: HRIEngineProfile
    before: frozenset[str]
    now: Mapping[str, Place]
    twice: frozenset[str]
    repeated: frozenset[str]


def compare_offers(parent_id: str, former: HRIEngineProfile | None, latter: HRIEngineProfile) -> ComparedOffers:
    """Compare two profiles that a bus offers.

    Args:
        parent_id: the engine that the bus is attached to.
        former: the `profile` of an earlier comparison; None where there was no offer.
        latter: what is offered now.
    """
    walk = _Walk()
    profile = walk.visit(parent_id, former, latter)
    return ComparedOffers(profile, frozenset(walk.before), walk.now, frozenset(walk.twice), frozenset(walk.repeated))


class _Walk:
    """Collects what differs."""

    def __init__(self) -> None:
        self.before: set[str] = set()
        self.now: dict[str, Place] = {}
        self.twice: set[str] = set()
        self.repeated: set[str] = set()

    def visit(self, parent_id: str, former: HRIEngineProfile | None, latter: HRIEngineProfile) -> HRIEngineProfile:
        """Visit an engine of the latter offer that is not the same object; return its profile, completed."""
        engine_id = latter.identifier.code
        if engine_id in self.now:
            self.twice.add(engine_id)
        # Before those below it: engines come in this order.
        self.now[engine_id] = Place(parent_id, (), latter.identifier)
        below = self._visit_below(engine_id, former, latter)
        refs = [ref for profile in below for ref in profile.component_ids]
        reachable = frozenset(refs)
        own = tuple(dict.fromkeys(ref for ref in latter.component_ids if ref not in reachable))
        self.now[engine_id] = Place(parent_id, own, latter.identifier, latter.parameter_profiles)
        self._note_repeated(refs, reachable)
        self._note_repeated(latter.component_ids, frozenset(latter.component_ids))
        complete = tuple(dict.fromkeys((*latter.component_ids, *refs)))
        if complete == latter.component_ids and all(map(_is_same, below, latter.sub_profiles)):
            return latter
        return latter.model_copy(update={"sub_profiles": tuple(below), "component_ids": complete})

    def _visit_below(
        self, engine_id: str, former: HRIEngineProfile | None, latter: HRIEngineProfile
    ) -> list[HRIEngineProfile]:
        same: dict[int, HRIEngineProfile] = {}
        if former is not None:
            self.before.add(former.identifier.code)
            same = {id(profile): profile for profile in former.sub_profiles}
        offered = {id(profile) for profile in latter.sub_profiles}
        others = {profile.identifier.code: profile for key, profile in same.items() if key not in offered}
        below = []
        for profile in latter.sub_profiles:
            if same.pop(id(profile), None) is not None:
                below.append(profile)
            else:
                below.append(self.visit(engine_id, others.pop(profile.identifier.code, None), profile))
        for profile in others.values():
            self.before.update(profile.engine_ids())
        return below

    def _note_repeated(self, refs: Iterable[str], once: frozenset[str]) -> None:
        listed = tuple(refs)
        if len(listed) > len(once):
            self.repeated.update(ref for ref, times in Counter(listed).items() if times > 1)


def _is_same(one: object, other: object) -> bool:
    return one is other
