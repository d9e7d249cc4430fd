"""The engines of a remote engine: the entries of its directory, put together to trees with their profiles."""

from collections import Counter
from collections.abc import Collection, Iterable, KeysView, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from openrois.contract import Directory
from openrois.engine.engine import MAX_DEPTH
from openrois.engine.profile_versions import profile_version
from openrois.errors import BadParameter, ComponentFailed
from openrois.types.directory import EngineEntry
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier
from openrois.types.references import engine_of, flaw_of_name

__all__ = ["FollowedEngine", "FollowedEngines", "together"]

MAX_ENGINES: Final = 65_536
"""Engines of one directory that is followed."""

MAX_COMPONENTS: Final = 1_048_576
"""Their components."""

MAX_TEXT: Final = 134_217_728
"""Characters of their profiles, each profile counted once."""

_MAX_VERSION: Final = 64
"""Characters of the version of a profile."""


@dataclass(frozen=True)
class FollowedEngine:
    """An engine right below the followed one, with all below it.

    Attributes:
        directory: its profile, and those of the components.
        streaming: the ids of those of its engines that have streams.
    """

    directory: Directory
    streaming: frozenset[str]


@dataclass(frozen=True, slots=True)
class _Known:
    """An engine as its entry describes it.

    Attributes:
        entry: without its components and extensions.
        has_streams: whether it has streams.
        versions: of the profiles of its own components, by their references.
        text: characters of what else its profile says.
    """

    entry: EngineEntry
    has_streams: bool
    versions: Mapping[str, str]
    text: int

    @property
    def parent_id(self) -> str:
        """The engine right above it."""
        return self.entry.parent_id


class FollowedEngines:
    """The engines of a directory. Entries come one by one, so that the trees of some may be torn for a while.

    Attributes:
        main_id: the engine that all others are below; empty before it is known.
        missing: for each version of a profile that is not known the engines and components that have it.
        roots: the engines right below the main one, as `take_changes` last gave them.
        main: the profile of the main engine without those below it, and its own components, as they were then.
    """

    def __init__(self) -> None:
        self.main_id = ""
        self.missing: dict[str, dict[tuple[str, str], None]] = {}
        self._roots: dict[str, FollowedEngine] = {}
        self.roots: Mapping[str, FollowedEngine] = MappingProxyType(self._roots)
        self.main: Directory | None = None
        self._known: dict[str, _Known] = {}
        self._children: dict[str, dict[str, None]] = {}
        self._nodes: dict[str, tuple[HRIEngineProfile, int]] = {}
        """The profile of each engine that is as it was when this was made, and how deep engines stand in it."""
        self._due: dict[str, None] = {}
        """Engines whose trees have changed: the highest of each that was known then."""
        self._profiles: dict[str, HRIComponentProfile] = {}
        self._uses: Counter[str] = Counter()
        """How many components have each version."""
        self._components = 0
        self._text = 0

    def ids(self) -> KeysView[str]:
        """Return the ids of all engines."""
        return self._known.keys()

    def streaming(self) -> frozenset[str]:
        """Return the ids of the engines that have streams, the main one among them."""
        main = self._known.get(self.main_id)
        own = {self.main_id} if main is not None and main.has_streams else set[str]()
        return frozenset(own.union(*(root.streaming for root in self._roots.values())))

    def keep(self, entry: EngineEntry) -> None:
        """Keep an entry in the place of the engine's former one.

        Raises:
            BadParameter: it cannot be part of a tree, or there is too much.
            ComponentFailed: there are two main engines.
        """
        self._require_fit(entry)
        self.drop(entry.engine_id)
        known = self._known[entry.engine_id] = _read(entry)
        if entry.parent_id:
            self._children.setdefault(entry.parent_id, {})[entry.engine_id] = None
        else:
            self.main_id = entry.engine_id
        self._components += len(known.versions)
        self._count(known.text)
        if len(self._known) > MAX_ENGINES or self._components > MAX_COMPONENTS:
            raise BadParameter(f"a directory may have {MAX_ENGINES} engines and {MAX_COMPONENTS} components at most")
        for component_ref, version in known.versions.items():
            self._uses[version] += 1
            if version not in self._profiles:
                self.missing.setdefault(version, {})[entry.engine_id, component_ref] = None
        self.touch(entry.engine_id)

    def _require_fit(self, entry: EngineEntry) -> None:
        if entry.identifier is not None and entry.identifier.code != entry.engine_id:
            raise ComponentFailed(f"the engine {entry.engine_id[:200]!r} has the identifier of another one")
        if flaw := flaw_of_name(entry.engine_id) or (flaw_of_name(entry.parent_id) if entry.parent_id else ""):
            raise BadParameter(
                f"the engine {entry.engine_id[:200]!r} cannot be in a tree: of its ids one is wrong: {flaw}"
            )
        if (entry.engine_id == self.main_id) == bool(entry.parent_id) and self.main_id:
            raise ComponentFailed(f"the directory has a main engine besides {self.main_id!r}, or none any more")
        seen = set[str]()
        for each in entry.components:
            head, _, name = each.component_ref.partition("/")
            flaw = flaw_of_name(head) or flaw_of_name(name) or ("it stands twice" if each.component_ref in seen else "")
            if flaw or not 0 < len(each.profile_version) <= _MAX_VERSION:
                flaw = flaw or f"its profile needs a version of 1 to {_MAX_VERSION} characters"
                raise BadParameter(f"the component {each.component_ref[:300]!r} cannot be in a tree: {flaw}")
            seen.add(each.component_ref)

    def drop(self, engine_id: str) -> None:
        """Drop an engine; one that is not known is ignored."""
        known = self._known.get(engine_id)
        if known is None:
            return
        self.touch(engine_id)
        del self._known[engine_id]
        if known.parent_id:
            siblings = self._children[known.parent_id]
            del siblings[engine_id]
            if not siblings:
                del self._children[known.parent_id]
        self._components -= len(known.versions)
        self._text -= known.text
        for component_ref, version in known.versions.items():
            self._release(version, (engine_id, component_ref))

    def _release(self, version: str, user: tuple[str, str]) -> None:
        self.missing.get(version, {}).pop(user, None)
        self._uses[version] -= 1
        if not self._uses[version]:
            del self._uses[version]
            self.missing.pop(version, None)
            profile = self._profiles.pop(version, None)
            if profile is not None:
                self._text -= profile_version(profile).size

    def touch(self, engine_id: str) -> None:
        """Note that an engine is another one now, or is as it was after it had left."""
        path = self._path(engine_id)
        for each in path:
            self._nodes.pop(each, None)
        self._due[path[-1]] = None

    def _path(self, engine_id: str) -> list[str]:
        """Return an engine and those above it, up to the one right below the main engine, as far as they are known."""
        path = [engine_id]
        while len(path) < MAX_DEPTH:
            known = self._known.get(path[-1])
            if known is None or known.parent_id not in self._known or known.parent_id == self.main_id:
                break
            path.append(known.parent_id)
        return path

    def adopt(self, version: str, profile: HRIComponentProfile) -> None:
        """Set the profile of a version; one that no component has is dropped.

        Raises:
            BadParameter: there is too much.
        """
        if self.missing.pop(version, None) is None:
            return
        self._profiles[version] = profile
        self._count(profile_version(profile).size)

    def _count(self, text: int) -> None:
        self._text += text
        if self._text > MAX_TEXT:
            raise BadParameter(f"the profiles of a directory may have {MAX_TEXT} characters at most")

    def take_changes(self, stale: Collection[str]) -> dict[str, FollowedEngine | None]:
        """Return the engines right below the main one that are others now, or are gone.

        Those that left and came back as they were are among them. Those that wait for an entry come another time.

        Args:
            stale: engines whose entries have to be read again.

        Raises:
            BadParameter: nothing is stale, and the engines are no tree.
        """
        waiting = {self._path(engine_id)[-1] for engine_id in stale}
        changes: dict[str, FollowedEngine | None] = {}
        due, self._due = self._due, {}
        for top in due:
            if top in self._roots and not self._is_root(top):
                changes[top] = None
                del self._roots[top]
            if top == self.main_id and top in self._known:
                self._take_main(is_stale=top in stale)
            if top == self.main_id or top not in self._known:
                continue
            root = self._path(top)[-1]
            if changes.get(root) is not None:
                continue
            built = None if root in waiting else self._built(root, is_torn=bool(stale))
            if built is None:
                self._due[top] = None
            else:
                changes[root] = self._roots[root] = built
        return changes

    def _take_main(self, *, is_stale: bool) -> None:
        if is_stale:
            self._due[self.main_id] = None
            return
        known = self._known[self.main_id]
        profiles = {ref: self._profiles[version] for ref, version in known.versions.items()}
        self.main = Directory(_profile(known, ()), profiles)

    def _is_root(self, engine_id: str) -> bool:
        known = self._known.get(engine_id)
        return known is not None and known.parent_id == self.main_id

    def _built(self, root: str, *, is_torn: bool) -> FollowedEngine | None:
        """Return the tree of an engine; None where it is torn."""
        try:
            if not self._is_root(root):
                raise BadParameter(f"the engine {root!r} is below an unknown one, below itself, or nested too deep")
            return self._tree(root)
        except BadParameter:
            if is_torn:
                return None
            raise

    def _tree(self, root: str) -> FollowedEngine:
        profile, height = self._node(root, 1)
        if height >= MAX_DEPTH:
            raise BadParameter(f"engines may be nested {MAX_DEPTH} deep at most")
        members = profile.engine_ids()
        leading = frozenset(members)
        profiles: dict[str, HRIComponentProfile] = {}
        for member in members:
            for component_ref, version in self._known[member].versions.items():
                if component_ref in profiles or engine_of(component_ref) not in leading:
                    raise BadParameter(f"the component {component_ref!r} stands twice, or belongs to no engine here")
                profiles[component_ref] = self._profiles[version]
        streaming = frozenset(member for member in members if self._known[member].has_streams)
        return FollowedEngine(Directory(profile, profiles), streaming)

    def _node(self, engine_id: str, depth: int) -> tuple[HRIEngineProfile, int]:
        """Return the profile of an engine, with how deep engines stand in it; what is as it was is the same object."""
        node = self._nodes.get(engine_id)
        if node is None:
            if depth >= MAX_DEPTH:
                raise BadParameter(f"engines may be nested {MAX_DEPTH} deep at most")
            below = [self._node(child, depth + 1) for child in sorted(self._children.get(engine_id, ()))]
            profile = _profile(self._known[engine_id], [profile for profile, _ in below])
            node = self._nodes[engine_id] = profile, 1 + max((height for _, height in below), default=0)
        return node


def together(main: Directory, roots: Iterable[FollowedEngine]) -> Directory:
    """Return the directory of a main engine with the engines right below it."""
    below = [root.directory for root in roots]
    profiles = dict(main.component_profiles)
    for each in below:
        profiles.update(each.component_profiles)
    profile = main.profile.model_copy(
        update={"sub_profiles": tuple(each.profile for each in below), "component_ids": tuple(profiles)}
    )
    return Directory(profile, profiles)


def _read(entry: EngineEntry) -> _Known:
    versions = {each.component_ref: each.profile_version for each in entry.components}
    kept = entry.model_copy(update={"components": (), "extensions": (), "version": ""})
    is_more = entry.identifier is not None or entry.parameter_profiles
    text = len(kept.model_dump_json()) if is_more else 0
    return _Known(kept, "rois.stream" in entry.extensions, versions, text)


def _profile(known: _Known, below: Iterable[HRIEngineProfile]) -> HRIEngineProfile:
    entry, sub_profiles = known.entry, tuple(below)
    return HRIEngineProfile(
        identifier=entry.identifier or RoISIdentifier(code=entry.engine_id),
        sub_profiles=sub_profiles,
        component_ids=(*known.versions, *(ref for profile in sub_profiles for ref in profile.component_ids)),
        parameter_profiles=entry.parameter_profiles,
    )
