"""Versions of component profiles: equal profiles have the same one. Pure."""

from dataclasses import dataclass
from hashlib import sha256
from typing import Final
from weakref import finalize

from openrois.types.profiles import HRIComponentProfile

__all__ = ["ProfileVersion", "profile_version", "short_digest"]

_DIGITS: Final = 16


@dataclass(frozen=True, slots=True)
class ProfileVersion:
    """What is known of a profile.

    Attributes:
        code: the version.
        size: characters of its JSON text.
    """

    code: str
    size: int


_KNOWN: Final[dict[int, ProfileVersion]] = {}
"""By the identity of each profile: it is much longer to write down than to look up."""


def profile_version(profile: HRIComponentProfile) -> ProfileVersion:
    """Return the version of a profile."""
    known = _KNOWN.get(id(profile))
    if known is None:
        text = profile.model_dump_json()
        known = _KNOWN[id(profile)] = ProfileVersion(short_digest(text), len(text))
        finalize(profile, _KNOWN.pop, id(profile), None)
    return known


def short_digest(text: str) -> str:
    """Return what stands for a text: 16 hexadecimal digits."""
    return sha256(text.encode(errors="surrogatepass")).hexdigest()[:_DIGITS]
