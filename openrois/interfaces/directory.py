"""`openrois.directory.*`: which engines there are, in pages, and the profiles of those that an application shows."""

from collections.abc import Iterable, Iterator
from typing import Final

from openrois.engine.entries import engine_entry
from openrois.engine.profile_versions import profile_version
from openrois.interfaces.operation import operation
from openrois.jsonrpc.session import Handler
from openrois.session.session import ApplicationSession
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

__all__ = ["methods"]

ROOM: Final = 262_144
"""Characters of JSON after which a reply takes nothing more."""

COMPONENTS: Final = 1024
"""Components of all engines of a reply, after which it takes no further engine."""


def methods(app: ApplicationSession) -> dict[str, Handler]:
    """Return the extension's method table."""
    directory = _Directory(app)
    return {
        "openrois.directory.list": operation(DirectoryListParams, DirectoryListResult, directory.list_engines),
        "openrois.directory.read": operation(DirectoryReadParams, DirectoryReadResult, directory.read),
        "openrois.directory.profiles": operation(
            DirectoryProfilesParams, DirectoryProfilesResult, directory.read_profiles
        ),
    }


class _Directory:
    """What one application sees."""

    def __init__(self, app: ApplicationSession) -> None:
        self._app = app

    async def list_engines(self, params: DirectoryListParams) -> DirectoryListResult:
        self._app.change_notice.flush()
        tree, wanted = self._app.engine.tree, frozenset(params.component_types)
        found: list[EngineEntry] = []
        components, after = 0, params.after
        for entry in self._entries(tree.engines_after(after)):
            if wanted and not wanted <= {each.component_type for each in entry.components}:
                continue
            if len(found) == params.limit or (found and components + len(entry.components) > COMPONENTS):
                return DirectoryListResult(engines=tuple(found), next=found[-1].engine_id, count=tree.engine_count)
            found.append(entry)
            components += len(entry.components)
        return DirectoryListResult(engines=tuple(found), count=tree.engine_count)

    async def read(self, params: DirectoryReadParams) -> DirectoryReadResult:
        self._app.change_notice.flush()
        found: list[EngineEntry] = []
        components, asked = 0, list(dict.fromkeys(params.engine_ids))
        for entry in self._entries(asked):
            if found and components + len(entry.components) > COMPONENTS:
                left = asked[asked.index(entry.engine_id) :]
                return DirectoryReadResult(engines=tuple(found), left=tuple(left))
            found.append(entry)
            components += len(entry.components)
        return DirectoryReadResult(engines=tuple(found))

    def _entries(self, engine_ids: Iterable[str]) -> Iterator[EngineEntry]:
        seen = self._app.engine
        entries = (engine_entry(seen.tree, engine_id, seen.has_streams) for engine_id in engine_ids)
        return (entry for entry in entries if entry is not None)

    async def read_profiles(self, params: DirectoryProfilesParams) -> DirectoryProfilesResult:
        profiles: dict[str, HRIComponentProfile] = {}
        size, asked = 0, list(dict.fromkeys(params.component_refs))
        for number, component_ref in enumerate(asked):
            profile = self._app.engine.components.get(component_ref)
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
