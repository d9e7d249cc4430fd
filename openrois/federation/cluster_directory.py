"""The engines of all gateways of a cluster as one tree, which each gateway keeps for its applications."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from openrois.aio.listeners import Listeners
from openrois.contract import Directory
from openrois.engine.lost_components import LostComponents
from openrois.engine.tree import Tree, TreeChange
from openrois.observability.logs import Tally
from openrois.types.codes import ComponentFunction

__all__ = ["ClusterDirectory", "Offer", "Origin"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Offer:
    """An engine right below the main one, with all engines below it, as a gateway offers it.

    Attributes:
        directory: of it.
        streaming: the ids of its engines that have the streaming methods.
    """

    directory: Directory
    streaming: frozenset[str] = field(default=frozenset())


@dataclass(eq=False, slots=True)
class Origin:
    """The place of an offer in the tree: the gateway and the engine, and what of it has streams now.

    Attributes:
        gateway_id: the gateway that offers the engine.
        root_id: the engine.
        streaming: the ids of its engines that have the streaming methods.
    """

    gateway_id: str
    root_id: str
    streaming: frozenset[str] = frozenset()


class ClusterDirectory:
    """What all gateways offer, as one tree.

    While an adapter changes its gateway two of them may offer its engine: the owner's offer stands, or else the latest.

    Args:
        engine_id: of the main engine, which all gateways have in common.
        owner_of: returns the gateway that owns an engine; None where that is not known.

    Attributes:
        tree: it.
        changes: called with each change of it.
        lost: components of gateways that were lost.
        lost_acting: those of them that act: STOP may still reach them.
    """

    def __init__(self, engine_id: str, owner_of: Callable[[str], str | None] = lambda _engine_id: None) -> None:
        self.tree: Tree[Origin] = Tree(engine_id)
        self.changes: Listeners[TreeChange] = Listeners()
        self.lost = LostComponents()
        self.lost_acting = LostComponents()
        self._owner_of = owner_of
        self._offers: dict[str, dict[str, Offer]] = {}
        self._shown: dict[str, tuple[Origin, Offer]] = {}
        self._blocked: set[str] = set()
        self._conflicts = Tally(_log, "engines whose ids another engine of the cluster has already", logging.WARNING)

    def gateway_of(self, engine_id: str) -> str | None:
        """Return the gateway where an engine is reached; None where there is no such engine below the main one."""
        origin = self.tree.bus_of(engine_id)
        return None if origin is None else origin.gateway_id

    def has_streams(self, engine_id: str) -> bool:
        """Tell whether an engine has the streaming methods."""
        origin = self.tree.bus_of(engine_id)
        return origin is not None and engine_id in origin.streaming

    @property
    def streaming(self) -> frozenset[str]:
        """The ids of all engines that have the streaming methods."""
        return frozenset[str]().union(*(origin.streaming for origin in self.tree.buses()))

    def put(self, gateway_id: str, offers: Mapping[str, Offer | None]) -> None:
        """Set what a gateway offers.

        Args:
            gateway_id: the gateway.
            offers: what has changed, by the root's id; None for an engine that is there no more.
        """
        for root_id, offer in offers.items():
            of_gateways = self._offers.setdefault(root_id, {})
            of_gateways.pop(gateway_id, None)
            if offer is not None:
                of_gateways[gateway_id] = offer
            self.settle(root_id)

    def remove_gateway(self, gateway_id: str, *, lost: bool) -> None:
        """Drop all that a gateway offers.

        Args:
            gateway_id: the gateway.
            lost: whether it was lost: what it offered counts as failing until it is offered again.
        """
        for root_id in [root_id for root_id, offers in self._offers.items() if gateway_id in offers]:
            shown = self._shown.get(root_id)
            self.put(gateway_id, {root_id: None})
            if lost and shown is not None and root_id not in self._shown:
                profiles = shown[1].directory.component_profiles
                self.lost.lose(profiles)
                self.lost_acting.lose(
                    ref for ref, profile in profiles.items() if profile.function is ComponentFunction.ACTUATION
                )

    def settle(self, root_id: str) -> None:
        """Let the offer of an engine stand that counts now: its owner may be another one."""
        offers = self._offers.get(root_id, {})
        chosen = self._owner_of(root_id)
        gateway_id = chosen if chosen in offers else next(reversed(offers), None)
        shown = self._shown.get(root_id)
        if gateway_id is None:
            self._offers.pop(root_id, None)
            self._hide(root_id)
        elif shown is None or shown[0].gateway_id != gateway_id:
            self._hide(root_id)
            self._show(Origin(gateway_id, root_id), offers[gateway_id])
        elif shown[1] is not offers[gateway_id]:
            self._show(shown[0], offers[gateway_id])
        self._unblock()

    def _hide(self, root_id: str) -> None:
        self._blocked.discard(root_id)
        shown = self._shown.pop(root_id, None)
        if shown is not None:
            self.changes.notify_all(self.tree.replace(shown[0], None))

    def _show(self, origin: Origin, offer: Offer) -> None:
        holders = {self.tree.bus_of(engine_id) for engine_id in offer.directory.profile.engine_ids()}
        if not holders <= {None, origin} or self.tree.engine_id in offer.directory.profile.engine_ids():
            self._conflicts.note(origin.root_id)
            self._hide(origin.root_id)
            self._blocked.add(origin.root_id)
            return
        self._blocked.discard(origin.root_id)
        self._shown[origin.root_id] = origin, offer
        origin.streaming = offer.streaming
        self.lost.found(offer.directory.component_profiles)
        self.lost_acting.found(offer.directory.component_profiles)
        self.changes.notify_all(self.tree.replace(origin, offer.directory))

    def _unblock(self) -> None:
        """Show engines whose ids have become free."""
        for root_id in tuple(self._blocked):
            offers = self._offers[root_id]
            gateway_id = next(reversed(offers))
            ids = offers[gateway_id].directory.profile.engine_ids()
            if all(self.tree.bus_of(engine_id) is None for engine_id in ids) and self.tree.engine_id not in ids:
                self._show(Origin(gateway_id, root_id), offers[gateway_id])
