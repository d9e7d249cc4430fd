"""The directory of a remote engine: listed once, and then only what has changed is read."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, Final

from openrois.engine.profile_versions import profile_version
from openrois.errors import ComponentFailed
from openrois.jsonrpc.session import NotificationHandler
from openrois.remote.followed_engines import FollowedEngine, FollowedEngines
from openrois.remote.rpc_call import RpcCalls
from openrois.remote.shared_profiles import profile_of_version, versioned_profile
from openrois.types.directory import (
    MAX_PAGE,
    MAX_PROFILES,
    DirectoryChangedNotification,
    DirectoryListParams,
    DirectoryListResult,
    DirectoryProfilesParams,
    DirectoryProfilesResult,
    DirectoryReadParams,
    DirectoryReadResult,
    EngineEntry,
)
from openrois.types.profiles import HRIComponentProfile
from openrois.types.references import flaw_of_name

__all__ = ["RemoteDirectory"]

MAX_STALE: Final = 4096
"""Changed engines that wait to be read; with more the directory is listed again."""

MAX_VAIN: Final = 8
"""Times that a profile is asked for which the other side names and does not give."""


class RemoteDirectory:
    """The engines of a remote engine that speaks `openrois.directory`; it has accepted a hello that names this.

    Args:
        calls: asks the other side.
        changed: called when it says that engines have changed: with their ids, or with None where it does not name all;
            must not block.

    Attributes:
        engines: what is known of it.
    """

    def __init__(self, calls: RpcCalls, changed: Callable[[Collection[str] | None], None]) -> None:
        self.engines = FollowedEngines()
        self._calls = calls
        self._changed = changed
        self._is_listed = False
        self._lists = 0
        """Counts how often the whole list became invalid."""
        self._stale: dict[str, None] = {}
        self._vain: Counter[str] = Counter()

    @property
    def is_listed(self) -> bool:
        """Whether all engines were listed, and the list is valid but for those that have changed."""
        return self._is_listed

    @property
    def is_settled(self) -> bool:
        """Whether nothing has to be read."""
        return self._is_listed and not self._stale

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handler of the notification of changes."""
        return {DirectoryChangedNotification.method: self._note_changes}

    def _note_changes(self, params: dict[str, Any]) -> None:
        notice = DirectoryChangedNotification.read_newer(params)
        self._stale.update((engine_id, None) for engine_id in notice.changed if not flaw_of_name(engine_id))
        for engine_id in notice.gone:
            self._drop(engine_id)
        if notice.unnamed or len(self._stale) > MAX_STALE:
            self._lists += 1
            self._is_listed = False
            self._stale.clear()
        self._changed(None if notice.unnamed else (*notice.changed, *notice.gone))

    def _drop(self, engine_id: str) -> None:
        self.engines.drop(engine_id)
        self._stale.pop(engine_id, None)

    async def read(self) -> dict[str, FollowedEngine | None]:
        """Read what has changed; return the engines right below the main one that are others now, None for gone ones.

        Those that left and came back as they were are among them. What changes meanwhile is left for the next time:
        `is_settled` tells.

        Raises:
            BadParameter: the directory is no tree, or too large.
            ComponentFailed: it contradicts itself.
            RoISError: it could not be read.
        """
        if self._is_listed:
            await self._read_stale()
        else:
            await self._list()
        await self._read_profiles()
        if not self._is_listed:
            return {}
        if self.engines.main_id not in self.engines.ids():
            raise ComponentFailed("the directory has no main engine")
        return self.engines.take_changes(self._stale)

    async def _list(self) -> None:
        lists, after, found = self._lists, "", set[str]()
        while True:
            page = await self._calls.ask(
                "openrois.directory.list",
                DirectoryListParams(after=after),
                DirectoryListResult,
                lambda page: self._keep(page.engines if lists == self._lists else ()),
            )
            if lists != self._lists:
                return
            ids = [entry.engine_id for entry in page.engines]
            if any(latter <= former for former, latter in zip([after, *ids], ids, strict=False)):
                raise ComponentFailed("the pages of the directory are not in the order of the engines' ids")
            found.update(ids)
            if not page.next:
                break
            if not ids or page.next < ids[-1]:
                raise ComponentFailed("the pages of the directory do not go on")
            after = page.next
        self._is_listed = True
        for engine_id in self.engines.ids() - found - self._stale.keys():
            self.engines.drop(engine_id)

    async def _read_stale(self) -> None:
        wanted = tuple(self._stale)
        while wanted and self._is_listed:
            wanted = await self._read_some(wanted[:MAX_PAGE]) + wanted[MAX_PAGE:]

    async def _read_some(self, asked: tuple[str, ...]) -> tuple[str, ...]:
        """Read the entries of some engines; return those that found no room."""
        lists = self._lists

        def accepted(result: DirectoryReadResult) -> None:
            # In the order of the connection: what changes from here on is noted again.
            read = set(asked) - set(result.left)
            ids = [entry.engine_id for entry in result.engines]
            if len(set(ids)) < len(ids) or not read.issuperset(ids) or (asked and not read):
                raise ComponentFailed("the engine answered openrois.directory.read with other engines than asked for")
            if lists == self._lists:
                for engine_id in read - set(ids):
                    self._drop(engine_id)
                self._keep(result.engines)

        params = DirectoryReadParams(engine_ids=asked)
        result = await self._calls.ask("openrois.directory.read", params, DirectoryReadResult, accepted)
        left = set(result.left)
        return tuple(engine_id for engine_id in asked if engine_id in left)

    def _keep(self, entries: Iterable[EngineEntry]) -> None:
        for entry in entries:
            self._stale.pop(entry.engine_id, None)
            self.engines.keep(entry)

    async def _read_profiles(self) -> None:
        """Read the profiles that are not known; an engine that has meanwhile another one is read again."""
        for version in tuple(self.engines.missing):
            known = profile_of_version(version)
            if known is not None:
                self.engines.adopt(version, known)
        wanted = [next(iter(users))[1] for users in self.engines.missing.values()]
        while wanted:
            wanted = [*await self._read_some_profiles(wanted[:MAX_PROFILES]), *wanted[MAX_PROFILES:]]
        self._vain = Counter({version: self._vain[version] + 1 for version in self.engines.missing})
        for version, users in self.engines.missing.items():
            if self._vain[version] > MAX_VAIN:
                raise ComponentFailed(f"the engine does not give the profile of {next(iter(users))[1]!r} that it names")
            self._stale.update((engine_id, None) for engine_id, _ in users)

    async def _read_some_profiles(self, asked: Sequence[str]) -> list[str]:
        """Read some profiles; return the components that found no room."""
        params = DirectoryProfilesParams(component_refs=tuple(asked))
        result = await self._calls.ask("openrois.directory.profiles", params, DirectoryProfilesResult)
        for version, profile in result.profiles.items():
            self.engines.adopt(version, _verified(version, profile))
        left = set(result.left)
        if not left < set(asked) and left:
            raise ComponentFailed(
                "the engine answered openrois.directory.profiles with other components than asked for"
            )
        return [component_ref for component_ref in asked if component_ref in left]


def _verified(version: str, profile: HRIComponentProfile) -> HRIComponentProfile:
    """Return the profile that stands for all of a version.

    Raises:
        ComponentFailed: it has another one.
    """
    shared = versioned_profile(profile)
    if profile_version(shared).code != version:
        raise ComponentFailed(f"the profile of the component {profile.name[:200]!r} has not the version that is named")
    return shared
