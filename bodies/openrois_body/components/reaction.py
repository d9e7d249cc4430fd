"""Reaction: gestures of head, arms and body (component 12), named by the identifiers of Annex D where it has one."""

from collections.abc import Callable
from typing import Any, Final, Protocol

from openrois.adapter import BadParameter, ComponentStatus, command, components
from openrois.catalog.reactions import ANNEX_D, NUMBERED

__all__ = ["Player", "Reaction", "reaction_ref"]

_LONGEST: Final = 30.0
"""Seconds after which a reaction counts as failed, so that an engine that never completes it blocks no other."""


def reaction_ref(name: str) -> str:
    """Return the ref of a game engine's reaction: its number in Annex D (informative), or its name for OpenRoIS."""
    if name in ANNEX_D:
        return f"{NUMBERED}{ANNEX_D[name]}"
    return f"urn:x-rois:def:reaction:OpenRoIS::{name}"


class Player(Protocol):
    """What plays reactions; `openrois_body.body.Body` implements it."""

    async def react(self, reaction: str) -> None:
        """Play a reaction to its end; raises Aborted and ComponentFailed. Cancelling this stops it."""
        ...


class Reaction(components.Reaction):
    """Plays the reaction that `reaction_ref` names; one at a time, a new one replaces the one that runs.

    Args:
        player: plays the reactions.
        reactions: returns the names that it offers now.
        engine_status: returns the status of the game engine.
    """

    def __init__(
        self,
        player: Player,
        reactions: Callable[[], tuple[str, ...]],
        engine_status: Callable[[], ComponentStatus],
    ) -> None:
        super().__init__()
        self._player = player
        self._reactions = reactions
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine."""
        return self._engine_status()

    def _names(self) -> dict[str, str]:
        return {reaction_ref(name): name for name in self._reactions()}

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse a reaction that the game engine does not offer."""
        wanted = changes.get("reaction_ref")
        if wanted is not None and wanted not in self._names():
            raise BadParameter(f"there is no reaction {wanted!r}; available_reactions lists them")
        return changes

    async def available_reactions(self) -> tuple[str, ...]:
        """Return the refs of the reactions the game engine offers."""
        return tuple(self._names())

    @command(timeout=_LONGEST)
    async def start(self) -> None:
        """Play the chosen reaction to its end."""
        name = self._names().get(self.reaction_ref or "")
        if name is None:
            raise BadParameter("reaction_ref is not set, or not offered; available_reactions lists the refs")
        await self._player.react(name)

    async def stop(self) -> None:
        """Stop the reaction; `start` ends with ABORT."""
