"""The reactions that the standard numbers, by their names here (Annex D, informative). Pure."""

from collections.abc import Mapping
from typing import Final

__all__ = ["ANNEX_D", "NUMBERED"]

NUMBERED: Final = "urn:x-rois:def:reaction:OMG::"
"""What stands before the number in a reference."""

ANNEX_D: Final[Mapping[str, int]] = {
    "nod": 1,
    "tilt": 2,
    "shake_head": 3,
    "bow": 9,
    "shake_hands": 10,
    "glance_at_watch": 50,
}
