"""Friendly names: gestures and places as words that a language model can choose from, and back. Pure."""

import re
from collections.abc import Iterable, Mapping
from typing import Final
from urllib.parse import unquote

__all__ = ["by_name", "gesture_name", "is_plain"]

MAX_NAME: Final = 40
"""Characters of a name in a list of choices."""

_ANNEX_D: Final[Mapping[str, str]] = {
    "1": "nod",
    "2": "tilt",
    "3": "shake_head",
    "9": "bow",
    "10": "shake_hands",
    "50": "glance_at_watch",
}
"""The standard numbers reactions (Annex D, informative)."""

_NUMBERED: Final = "urn:x-rois:def:reaction:OMG::"
_PLAIN: Final = re.compile(r"\w[\w .'-]*")
"""Letters and digits of any script, and what names have between them."""


def gesture_name(reaction_ref: str) -> str:
    """Return the name of a reaction: what the standard calls it, or the end of its identifier."""
    code = reaction_ref.rpartition("::")[2] or reaction_ref
    name = _ANNEX_D.get(code, code) if reaction_ref.startswith(_NUMBERED) else code
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
