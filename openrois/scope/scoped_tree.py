"""A tree of engines as one principal sees it: every reference of its applications is looked up here."""

from collections.abc import Callable, Mapping
from typing import Any

from openrois.aio.listeners import Listeners
from openrois.auth.principal import Principal
from openrois.engine.tree import Tree
from openrois.errors import Unsupported
from openrois.scope.views import TreeSource, ViewChange, Views
from openrois.types.profiles import HRIComponentProfile
from openrois.types.references import engine_of

__all__ = ["ScopedTree"]


class ScopedTree:
    """The part of a tree of engines that is in the scope of a principal.

    What is out of scope is refused by the look-up that refuses what does not exist, with the same words.

    Args:
        source: the whole tree.
        principal: whose scope it is.
        views: of the tree.
    """

    def __init__(self, source: TreeSource, principal: Principal, views: Views) -> None:
        self._source = source
        self._principal = principal
        self._views = views
        self._changes: Listeners[ViewChange] = Listeners()
        self._view = views.enter(principal)
        self._stop_following = self._view.changes.add(self._changes.notify_all)

    def close(self) -> None:
        """Stop following the tree."""
        self._stop_following()
        self._views.leave(self._view)

    @property
    def tree(self) -> Tree[Any]:
        """What there is for the principal now."""
        return self._view.tree

    @property
    def components(self) -> Mapping[str, HRIComponentProfile]:
        """The profile of every component that there is for the principal now, by its reference."""
        return self._view.tree.components

    @property
    def principal(self) -> Principal:
        """The principal; another one may take its place at any time, and its scope holds at once."""
        return self._principal

    @principal.setter
    def principal(self, principal: Principal) -> None:
        former, is_other = self._view, principal.scope != self._principal.scope
        self._principal = principal
        if not is_other:
            return
        self._stop_following()
        self._view = self._views.enter(principal)
        self._stop_following = self._view.changes.add(self._changes.notify_all)
        visible = former.tree.directory != self._view.tree.directory
        gone = frozenset(former.tree.components.keys() - self._view.tree.components.keys())
        engine_ids = frozenset(former.tree.engine_ids | self._view.tree.engine_ids) if visible else frozenset[str]()
        self._views.leave(former)
        self._changes.notify_all(ViewChange(visible, engine_ids, gone))

    def on_change(self, listener: Callable[[ViewChange], None]) -> Callable[[], None]:
        """Call `listener`, which must not block, whenever the tree or the scope changes; return what ends that."""
        return self._changes.add(listener)

    def sees(self, component_ref: str) -> bool:
        """Tell whether a component is in scope, whether it exists or not."""
        return self._principal.sees(component_ref)

    def hides(self, component_ref: str) -> bool:
        """Tell whether a component exists and is out of scope: for the audit trail, never for an answer."""
        is_there, is_seen = component_ref in self._source.tree.components, self.sees(component_ref)
        return is_there and not is_seen

    def require(self, component_ref: str) -> HRIComponentProfile:
        """Return the profile of a component.

        Raises:
            Unsupported: it does not exist, or is out of scope.
        """
        profile = self.components.get(component_ref)
        if profile is None:
            raise Unsupported(f"there is no component {component_ref[:200]!r}")
        return profile

    def require_engine(self, ref_or_id: str) -> None:
        """Do nothing where the engine that leads a reference or id is in scope.

        Raises:
            Unsupported: it does not exist, or is out of scope.
        """
        if not self.tree.has_engine(engine_of(ref_or_id)):
            raise Unsupported(f"there is no engine for {ref_or_id[:200]!r}")
