"""Abilities: the tools that act on a body, and the type of component that each of them needs. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from openrois.catalog.actuation import NAVIGATION, REACTION, SPEECH_SYNTHESIS
from openrois.types.profiles import component_urn

__all__ = ["ABILITIES", "Ability"]


@dataclass(frozen=True, slots=True)
class Ability:
    """An ability of a body.

    Attributes:
        urn: the type of the component that has it.
        moves: whether it moves the body; the rate of movements holds for it then.
        is_usual: whether a task that names no tools has it, where the body does.
    """

    urn: str
    moves: bool
    is_usual: bool


ABILITIES: Final[Mapping[str, Ability]] = MappingProxyType(
    {
        "say": Ability(SPEECH_SYNTHESIS.urn, moves=False, is_usual=True),
        "gesture": Ability(REACTION.urn, moves=True, is_usual=True),
        "look_at": Ability(component_urn("Gaze", "OpenRoIS"), moves=True, is_usual=True),
        "go_to": Ability(NAVIGATION.urn, moves=True, is_usual=False),
    }
)
"""By the name of the tool; `call` needs none in advance."""
