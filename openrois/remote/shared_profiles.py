"""Component profiles that many engines have in common, such as those of robots of one make, are kept once."""

from typing import Final
from weakref import ReferenceType, WeakKeyDictionary, WeakValueDictionary, ref

from openrois.engine.profile_versions import profile_version
from openrois.types.profiles import HRIComponentProfile

__all__ = ["profile_of_version", "shared_profile", "versioned_profile"]

_KEPT: Final[WeakKeyDictionary[HRIComponentProfile, ReferenceType[HRIComponentProfile]]] = WeakKeyDictionary()
"""Each profile that something refers to, by its value."""

_VERSIONED: Final[WeakValueDictionary[str, HRIComponentProfile]] = WeakValueDictionary()
"""Those whose version was computed here, by it."""


def shared_profile(profile: HRIComponentProfile) -> HRIComponentProfile:
    """Return the profile that stands for all which are equal to this one."""
    found = _KEPT.get(profile)
    kept = None if found is None else found()
    if kept is None:
        kept = profile
        _KEPT[profile] = ref(profile)
    return kept


def versioned_profile(profile: HRIComponentProfile) -> HRIComponentProfile:
    """Return the profile that stands for all which are equal to this one, which is found by its version from now on."""
    kept = shared_profile(profile)
    return _VERSIONED.setdefault(profile_version(kept).code, kept)


def profile_of_version(version: str) -> HRIComponentProfile | None:
    """Return a profile that has a version; None where none is kept."""
    return _VERSIONED.get(version)
