"""Reaction: gestures of head, arms and body (component 12), named by the identifiers of Annex D where it has one."""

from collections.abc import Callable
from typing import Final

from openrois.component import Component, command, parameter_profile, query
from openrois.errors import BadParameter
from openrois.types.codes import ComponentFunction, ComponentStatus
from openrois.types.messages import Result
from openrois.types.profiles import CommandMessageProfile, QueryMessageProfile
from openrois.types.values import encode_list
from openrois_avatar.body import Body
from openrois_avatar.components.profiles import component_profile

__all__ = ["Reaction", "reaction_ref"]

_LONGEST_MS: Final = 30_000
"""After this a reaction counts as failed: a game engine that forgets to say that one is over must not block others."""

_ANNEX_D: Final = {
    "nod": 1,
    "tilt": 2,
    "shake_head": 3,
    "bow": 9,
    "shake_hands": 10,
    "glance_at_watch": 50,
}


def reaction_ref(name: str) -> str:
    """Return the ref of a game engine's reaction: its number in Annex D (informative), or its name in our own book."""
    if name in _ANNEX_D:
        return f"urn:x-rois:def:reaction:OMG::{_ANNEX_D[name]}"
    return f"urn:x-rois:def:reaction:OpenRoIS::{name}"


class Reaction(Component):
    """Plays the reaction that `reaction_ref` names; one at a time, a new one replaces the one that runs.

    Args:
        body: what plays them.
        reactions: the names that the game engine offers now.
        engine_status: tells whether the game engine works now.
    """

    def __init__(
        self, body: Body, reactions: Callable[[], tuple[str, ...]], engine_status: Callable[[], ComponentStatus]
    ) -> None:
        super().__init__(
            component_profile(
                "Reaction",
                ComponentFunction.ACTUATION,
                commands=(CommandMessageProfile(name="start", timeout=_LONGEST_MS), CommandMessageProfile(name="stop")),
                queries=(
                    QueryMessageProfile(
                        name="available_reactions",
                        results=(parameter_profile("available_reactions", "RoISIdentifier[]"),),
                    ),
                ),
                parameters=(parameter_profile("reaction_ref", "RoISIdentifier"),),
            )
        )
        self._body = body
        self._reactions = reactions
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Follow the game engine."""
        return self._engine_status()

    def _names(self) -> dict[str, str]:
        return {reaction_ref(name): name for name in self._reactions()}

    def accept_parameters(self, values: dict[str, str]) -> dict[str, str]:
        """Refuse a reaction that the game engine does not have."""
        wanted = values.get("reaction_ref")
        if wanted is not None and wanted not in self._names():
            raise BadParameter(f"there is no reaction {wanted!r}; available_reactions lists them")
        return values

    @query("available_reactions")
    async def available_reactions(self) -> tuple[Result, ...]:
        """Return the refs of the reactions the game engine offers."""
        refs = encode_list(list(self._names()))
        return (Result(name="available_reactions", data_type_ref="RoISIdentifier[]", value=refs),)

    @command("start")
    async def start(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        """Play the chosen reaction to its end."""
        name = self._names().get(self.parameters["reaction_ref"])
        if name is None:
            raise BadParameter("set reaction_ref first")
        await self._body.react(name)
        return ()
