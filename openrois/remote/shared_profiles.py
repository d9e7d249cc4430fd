"""Component profiles that many engines have in common, such as those of robots of one make, are kept once."""

from typing import Final
from weakref import ReferenceType, WeakKeyDictionary, ref

from openrois.types.profiles import HRIComponentProfile

__all__ = ["shared_profile"]

_KEPT: Final[WeakKeyDictionary[HRIComponentProfile, ReferenceType[HRIComponentProfile]]] = WeakKeyDictionary()
"""Each profile that something refers to, by its value."""


def shared_profile(profile: HRIComponentProfile) -> HRIComponentProfile:
    """Return the profile that stands for all which are equal to this one."""
    found = _KEPT.get(profile)
    kept = None if found is None else found()
    if kept is None:
        kept = profile
        _KEPT[profile] = ref(profile)
    return kept
