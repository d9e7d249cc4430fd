"""Friendly names: gestures and places as words that a language model can choose from, and back. Pure."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final
from urllib.parse import unquote

from openrois.catalog.reactions import ANNEX_D, NUMBERED

__all__ = ["Vocabulary", "by_name", "gesture_name", "is_plain"]

MAX_NAME: Final = 40
"""Characters of a name in a list of choices."""

_BY_NUMBER: Final = {str(number): name for name, number in ANNEX_D.items()}
_PLAIN: Final = re.compile(r"\w[\w .'-]*")
"""Letters and digits of any script, and what names have between them."""


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """Names over all bodies, sorted, each once.

    Attributes:
        bodies: their ids.
        gestures: what `gesture` takes.
        places: what `go_to` takes.
        events: what `wait_for_event` takes.
    """

    bodies: tuple[str, ...] = ()
    gestures: tuple[str, ...] = ()
    places: tuple[str, ...] = ()
    events: tuple[str, ...] = ()


def gesture_name(reaction_ref: str) -> str:
    """Return the name of a reaction: what the standard calls it, or the end of its identifier."""
    code = reaction_ref.rpartition("::")[2] or reaction_ref
    name = _BY_NUMBER.get(code, code) if reaction_ref.startswith(NUMBERED) else code
    return re.sub(r"\W+", "_", unquote(name), flags=re.ASCII).strip("_").lower()[:MAX_NAME] or "gesture"


def by_name(reaction_refs: Iterable[str]) -> dict[str, str]:
    """Return reactions by their names; of those with the same name the later ones are numbered."""
    found: dict[str, str] = {}
    for ref in reaction_refs:
        name, number = gesture_name(ref), 1
        while (chosen := name if number == 1 else f"{name}_{number}") in found:
            number += 1
        found[chosen] = ref
    return found


def is_plain(name: str) -> bool:
    """Tell whether a name is short, and of letters and digits: what has more in it is no name, or meant to be more."""
    return len(name) <= MAX_NAME and _PLAIN.fullmatch(name) is not None
