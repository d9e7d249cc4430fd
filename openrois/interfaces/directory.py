"""`openrois.directory.*`: which engines there are, in pages, and the profiles of those that an application shows."""

from collections.abc import Iterable, Mapping
from typing import Final, Protocol

from openrois.engine.entries import engine_entry
from openrois.engine.profile_versions import profile_version
from openrois.interfaces.operation import shared_operation
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.scope.scoped_tree import ScopedTree
from openrois.session.change_notice import ChangeNotice
from openrois.types.directory import (
    DirectoryListParams,
    DirectoryListResult,
    DirectoryProfilesParams,
    DirectoryProfilesResult,
    DirectoryReadParams,
    DirectoryReadResult,
    EngineEntry,
)
from openrois.types.profiles import HRIComponentProfile

__all__ = ["DirectoryReader", "methods"]

ROOM: Final = 262_144
"""Characters of JSON after which a reply takes nothing more."""

ITEMS: Final = 1024
"""Components and parameters of all engines of a reply, after which it takes no further engine."""


class DirectoryReader(Protocol):
    """An application that reads a directory."""

    @property
    def engine(self) -> ScopedTree:
        """What it sees."""
        ...

    @property
    def change_notice(self) -> ChangeNotice:
        """Notifies it of changes."""
        ...

    def has_streams(self, engine_id: str) -> bool:
        """Tell whether it sees an engine that has the streaming methods."""
        ...


class _Directory:
    """What one application sees."""

    def __init__(self, reader: DirectoryReader) -> None:
        self._reader = reader

    async def list_engines(self, params: DirectoryListParams) -> DirectoryListResult:
        self._reader.change_notice.flush()
        tree, wanted = self._reader.engine.tree, frozenset(params.component_types)
        chosen = (each for each in tree.engines_after(params.after) if self._owns(each, wanted))
        found, left = self._page(chosen, params.limit)
        return DirectoryListResult(engines=found, next=found[-1].engine_id if left else "", count=tree.engine_count)

    async def read(self, params: DirectoryReadParams) -> DirectoryReadResult:
        self._reader.change_notice.flush()
        asked = list(dict.fromkeys(params.engine_ids))
        found, left = self._page(asked, len(asked))
        return DirectoryReadResult(engines=found, left=tuple(asked[asked.index(left) :]) if left else ())

    def _owns(self, engine_id: str, wanted: frozenset[str]) -> bool:
        """Tell whether an engine owns a component of each type; it has no entry made for that."""
        if not wanted:
            return True
        tree = self._reader.engine.tree
        place = tree.place_of(engine_id)
        return place is not None and wanted <= {tree.components[ref].component_type for ref in place.component_refs}

    def _page(self, engine_ids: Iterable[str], limit: int) -> tuple[tuple[EngineEntry, ...], str]:
        """Return the entries of the first engines that a reply has room for, and the next engine; empty for none."""
        seen = self._reader.engine
        found: list[EngineEntry] = []
        items = 0
        for engine_id in engine_ids:
            entry = engine_entry(seen.tree, engine_id, self._reader.has_streams)
            if entry is None:
                continue
            items += len(entry.components) + len(entry.parameter_profiles)
            if len(found) == limit or (found and items > ITEMS):
                return tuple(found), engine_id
            found.append(entry)
        return tuple(found), ""

    async def read_profiles(self, params: DirectoryProfilesParams) -> DirectoryProfilesResult:
        profiles: dict[str, HRIComponentProfile] = {}
        size, asked = 0, list(dict.fromkeys(params.component_refs))
        for number, component_ref in enumerate(asked):
            profile = self._reader.engine.components.get(component_ref)
            if profile is None:
                continue
            version = profile_version(profile)
            if version.code in profiles:
                continue
            if profiles and size + version.size > ROOM:
                return DirectoryProfilesResult(profiles=profiles, left=tuple(asked[number:]))
            profiles[version.code] = profile
            size += version.size
        return DirectoryProfilesResult(profiles=profiles)


_METHODS: Final[Mapping[str, SharedMethod]] = {
    "openrois.directory.list": shared_operation(DirectoryListParams, DirectoryListResult, _Directory.list_engines),
    "openrois.directory.read": shared_operation(DirectoryReadParams, DirectoryReadResult, _Directory.read),
    "openrois.directory.profiles": shared_operation(
        DirectoryProfilesParams, DirectoryProfilesResult, _Directory.read_profiles
    ),
}


def methods(reader: DirectoryReader) -> BoundMethods:
    """Return the extension's methods."""
    return BoundMethods((_METHODS, _Directory(reader)))
