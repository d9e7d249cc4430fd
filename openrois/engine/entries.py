"""The engines of a tree in short, as `openrois.directory` describes them. Pure."""

from collections.abc import Callable
from typing import Any

from openrois.engine.profile_versions import profile_version, short_digest
from openrois.engine.tree import Tree
from openrois.types.directory import ComponentEntry, EngineEntry
from openrois.types.profiles import RoISIdentifier
from openrois.types.streams import EXTENSIONS

__all__ = ["engine_entry"]


def engine_entry(tree: Tree[Any], engine_id: str, has_streams: Callable[[str], bool]) -> EngineEntry | None:
    """Return the entry of an engine; None where it is not in the tree.

    Args:
        tree: what is seen.
        engine_id: the engine.
        has_streams: tells whether an engine has the streaming methods.
    """
    place = tree.place_of(engine_id)
    if place is None:
        return None
    components = tuple(_component_entry(tree, ref) for ref in place.component_refs)
    entry = EngineEntry(
        engine_id=engine_id,
        parent_id=place.parent_id,
        version="",
        extensions=EXTENSIONS if has_streams(engine_id) else (),
        components=components,
        identifier=None if place.identifier == RoISIdentifier(code=engine_id) else place.identifier,
        parameter_profiles=place.parameter_profiles,
    )
    return entry.model_copy(update={"version": short_digest(entry.model_dump_json())})


def _component_entry(tree: Tree[Any], component_ref: str) -> ComponentEntry:
    profile = tree.components[component_ref]
    return ComponentEntry(
        component_ref=component_ref,
        component_type=profile.component_type,
        function=profile.function,
        profile_version=profile_version(profile).code,
    )
