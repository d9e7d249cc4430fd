"""Bodies in a gateway's profile: the engines that own components, and what each of them can do.

RoIS 2.0 knows engines and components. A body is an engine that owns components: it lists some that no engine below it
lists. What is reachable through it belongs to it, too. Behind the main engine stand all bodies, so that of those it has
only what it owns itself: a body is never put together from two robots.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from openrois.catalog.component_type import ComponentType
from openrois.client.component import ComponentProxy
from openrois.types.directory import EngineEntry
from openrois.types.messages import ProfileResult
from openrois.types.profiles import HRIEngineProfile, component_urn

__all__ = ["BodyComponent", "BodyInfo", "BodyProfile", "Kind", "bodies_in", "bodies_of", "code_of", "urn_of"]

Kind = type[ComponentProxy] | ComponentType | str
"""A component type: a class of `openrois.client.components` or one's own, a `ComponentType`, its URN, or the code of a
basic component, such as `"Navigation"`."""


def urn_of(kind: Kind) -> str:
    """Return the URN of a component type.

    Raises:
        TypeError: it is no component type, or a class without one.
    """
    if isinstance(kind, str):
        return kind if kind.startswith("urn:") else component_urn(kind)
    found = kind if isinstance(kind, ComponentType) else getattr(kind, "component_type", None)
    if not isinstance(found, ComponentType):
        raise TypeError(f"{kind} has no component_type to look for")
    return found.urn


def code_of(urn: str) -> str:
    """Return the code of a component type without its authority, such as `Navigation`."""
    return urn.rpartition(":")[2]


@dataclass(frozen=True, slots=True)
class BodyProfile:
    """A body as the profile describes it.

    Attributes:
        engine_id: the engine.
        types: the URN of each component's type, by component_ref in sorted order.
    """

    engine_id: str
    types: Mapping[str, str]

    def has(self, urns: Iterable[str]) -> bool:
        """Tell whether the body has a component of each of these types."""
        return set(urns) <= set(self.types.values())

    def codes(self) -> str:
        """Return what the body can do in one line, `Navigation, Reaction`."""
        return ", ".join(sorted({code_of(urn) for urn in self.types.values()}))


@dataclass(frozen=True, slots=True)
class BodyComponent:
    """A component of a body.

    Attributes:
        component_ref: its reference.
        component_type: the URN of its type.
        free: whether no application holds it; None where the gateway does not tell. What needs no reservation is free.
    """

    component_ref: str
    component_type: str
    free: bool | None


@dataclass(frozen=True, slots=True)
class BodyInfo:
    """A body: what it can do, and whether it is free.

    Attributes:
        engine_id: the engine, which leads the references of its components.
        components: its components, sorted by reference.
    """

    engine_id: str
    components: tuple[BodyComponent, ...]

    @property
    def free(self) -> bool | None:
        """Whether no application holds any part of it; None where the gateway does not tell."""
        told = {component.free for component in self.components}
        return False if False in told else None if None in told else True

    def refs(self, kind: Kind) -> tuple[str, ...]:
        """Return the references of its components of a type; empty where it has none."""
        urn = urn_of(kind)
        return tuple(each.component_ref for each in self.components if each.component_type == urn)


@dataclass(frozen=True, slots=True)
class _Engine:
    """An engine with the types of the components that it owns, and the engines right below it."""

    engine_id: str
    types: Mapping[str, str]
    below: tuple["_Engine", ...]


def bodies_in(answer: ProfileResult) -> tuple[BodyProfile, ...]:
    """Return the bodies of a gateway in the order of their ids, inner engines before those around them.

    Args:
        answer: to `get_profile`; of one with a condition, only components that meet it belong to a body.
    """
    if answer.profile is None:
        return ()
    types = {ref: profile.component_type for ref, profile in answer.component_profiles.items()}

    def read(profile: HRIEngineProfile) -> _Engine:
        own = {ref: types[ref] for ref in profile.own_refs() if ref in types}
        return _Engine(profile.identifier.code, own, tuple(map(read, profile.sub_profiles)))

    return _bodies_behind(read(answer.profile))


def bodies_of(entries: Iterable[EngineEntry]) -> tuple[BodyProfile, ...]:
    """Return the bodies of a directory in the order of their ids, inner engines before those around them."""
    below: dict[str, list[EngineEntry]] = {}
    for entry in entries:
        below.setdefault(entry.parent_id, []).append(entry)

    def read(entry: EngineEntry) -> _Engine:
        own = {each.component_ref: each.component_type for each in entry.components}
        return _Engine(entry.engine_id, own, tuple(map(read, below.get(entry.engine_id, ()))))

    return tuple(body for main in below.get("", ()) for body in _bodies_behind(read(main)))


def _bodies_behind(main: _Engine) -> tuple[BodyProfile, ...]:
    """Return the bodies behind a main engine, which has of them only what it owns itself."""
    found: list[BodyProfile] = []
    for engine in _sorted(main.below):
        _add_bodies(found, engine)
    if main.types:
        found.append(_body(main.engine_id, main.types))
    return tuple(found)


def _add_bodies(found: list[BodyProfile], engine: _Engine) -> dict[str, str]:
    """Add the bodies of an engine and of those below it; return the types of all their components."""
    types = dict(engine.types)
    for sub_engine in _sorted(engine.below):
        types |= _add_bodies(found, sub_engine)
    if engine.types:
        found.append(_body(engine.engine_id, types))
    return types


def _sorted(engines: Iterable[_Engine]) -> list[_Engine]:
    return sorted(engines, key=lambda engine: engine.engine_id)


def _body(engine_id: str, types: Mapping[str, str]) -> BodyProfile:
    return BodyProfile(engine_id, dict(sorted(types.items())))
