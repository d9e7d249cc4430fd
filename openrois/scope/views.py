"""What applications of each scope see of an engine: those of one scope share a view, which follows the tree."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from openrois.aio.listeners import Listeners
from openrois.auth.principal import Principal, engines_named
from openrois.contract import Directory
from openrois.engine.tree import Tree, TreeChange
from openrois.scope.filter import scoped_directory

__all__ = ["TreeSource", "View", "ViewChange", "Views"]


class TreeSource(Protocol):
    """A tree of engines that tells how it changes.

    Attributes:
        tree: it.
        changes: called with each change; they must not block.
    """

    tree: Tree[Any]
    changes: Listeners[TreeChange]


@dataclass(frozen=True, slots=True)
class ViewChange:
    """A change of what is seen.

    Attributes:
        visible: whether something can be seen of it.
        engine_ids: the engines that it may be about.
        gone_refs: the components that are not seen any more.
    """

    visible: bool
    engine_ids: frozenset[str] = frozenset()
    gone_refs: frozenset[str] = frozenset()


class View:
    """What is seen of a tree.

    Attributes:
        tree: what is seen, and no more.
        changes: called when that has changed.
        users: how many follow it.
    """

    def __init__(self, principal: Principal, tree: Tree[Any]) -> None:
        self.tree = tree
        self.changes: Listeners[ViewChange] = Listeners()
        self.users = 0
        self.principal = principal

    def show(self, bus: Any, offer: Directory | None) -> TreeChange:
        """Set what is seen of a bus, given what it offers; return the change."""
        shown = None if offer is None else scoped_directory(offer, self.principal)
        return self.tree.replace(bus, shown if shown is not None and shown.component_profiles else None)


class Views:
    """The views of one tree.

    Args:
        source: that is seen.
    """

    def __init__(self, source: TreeSource) -> None:
        self._source = source
        self._views: dict[tuple[str, ...], View] = {}
        self._naming: dict[str, dict[View, None]] = {}
        """Views of scopes that name the only engines they are about, by these."""
        self._others: dict[View, None] = {}
        source.changes.add(self._follow)

    def enter(self, principal: Principal) -> View:
        """Return the view of a principal's scope; `leave` it."""
        view = self._views.get(principal.scope)
        if view is None:
            view = self._views[principal.scope] = self._made(principal)
        view.users += 1
        return view

    def leave(self, view: View) -> None:
        """Follow a view no longer; one that is not followed is dropped."""
        view.users -= 1
        if view.users:
            return
        del self._views[view.principal.scope]
        self._others.pop(view, None)
        for engine_id in engines_named(view.principal.scope) or ():
            self._naming[engine_id].pop(view)
            if not self._naming[engine_id]:
                del self._naming[engine_id]

    def _made(self, principal: Principal) -> View:
        tree = self._source.tree
        if principal.sees_everything:
            view = View(principal, tree)
            self._others[view] = None
            return view
        view = View(principal, Tree(tree.engine_id))
        named = engines_named(principal.scope)
        if named is None:
            self._others[view] = None
            buses = list(tree.buses())
        else:
            for engine_id in named:
                self._naming.setdefault(engine_id, {})[view] = None
            concerned = {tree.bus_of(engine_id) for engine_id in named}
            buses = [bus for bus in tree.buses() if bus in concerned]
        for bus in buses:
            view.show(bus, tree.offer_of(bus))
        return view

    def _follow(self, change: TreeChange) -> None:
        for view in tuple(self._concerned(change)):
            if view.tree is self._source.tree:
                # Any change is one, also that of an engine which comes back as it was.
                view.changes.notify_all(ViewChange(True, change.engine_ids, change.gone_refs))
                continue
            seen = view.show(change.bus, change.latter)
            if seen.former is not None or seen.latter is not None:
                # What is seen is a copy in which all engines are new; those that have not changed are not named.
                engine_ids = seen.engine_ids & change.engine_ids
                view.changes.notify_all(ViewChange(seen.former != seen.latter, engine_ids, seen.gone_refs))

    def _concerned(self, change: TreeChange) -> Iterator[View]:
        yield from self._others
        named = (self._naming.get(engine_id, {}) for engine_id in change.engine_ids)
        yield from dict.fromkeys(view for views in named for view in views)
