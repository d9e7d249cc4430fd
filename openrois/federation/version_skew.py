"""How far the version of another gateway's program is from this one's. Pure."""

import re
from typing import Final

__all__ = ["is_tried", "told_version"]

_MOST_APART: Final = 1
"""Minor releases that two gateways of one cluster may be apart."""

_NUMBERS: Final = re.compile(r"(\d{1,6})\.(\d{1,6})(?:\.|$)")


def is_tried(theirs: str, ours: str) -> bool:
    """Tell whether gateways of two versions are known to work together."""
    numbers = [_NUMBERS.match(version) for version in (theirs, ours)]
    if None in numbers:
        return theirs == ours
    (their_major, their_minor), (our_major, our_minor) = (map(int, found.groups()) for found in numbers if found)
    return their_major == our_major and abs(their_minor - our_minor) <= _MOST_APART


def told_version(gateway_id: str, theirs: str, ours: str) -> str:
    """Return what an operator has to know of a gateway with another version."""
    told = f"gateway {gateway_id} runs OpenRoIS {theirs}, and this one is {ours}"
    return told if is_tried(theirs, ours) else f"{told}: upgrade by one minor release at a time, nothing else is tried"
