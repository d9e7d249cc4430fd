"""Limit on the renditions of a source that are encoded at a time, and their substitutes. Pure."""

from collections.abc import Iterable, Sequence
from math import inf, log
from typing import Final, Protocol, TypeVar

from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.errors import NoEncoder

ENCODERS_LIMIT: Final = 6
"""Default number of encoders of one source at a time: three sizes in two codecs."""


class Encodable(Protocol):
    """Rendition, as far as the limit needs it."""

    @property
    def mime_type(self) -> str:
        """Its codec."""
        ...

    @property
    def rung(self) -> Rung | None:
        """Its size and pace."""
        ...

    @property
    def is_wanted(self) -> bool:
        """Whether a viewer plays the rendition, so that its encoder runs."""
        ...


T = TypeVar("T", bound=Encodable)


def within_limit(asked: Sequence[T], first: T, made: Iterable[T], limit: int, codecs: int) -> tuple[T, ...]:
    """Return the renditions that a viewer can have in place of those that suit it.

    An encoder is reserved for the first rendition of each codec, the largest at the full pace: whatever other viewers
    ask for, it stays available. Where no encoder is left, the nearest running rendition replaces the one that would
    need another.

    Args:
        asked: renditions of one codec that suit the viewer.
        first: the first rendition of that codec.
        made: all renditions of the source.
        limit: how many may be encoded at a time.
        codecs: how many codecs there are.

    Raises:
        NoEncoder: not even the first one can be encoded; only where there are fewer encoders than codecs.
    """
    wanted = [each for each in made if each.is_wanted]
    room = sum(not _is_first(each) for each in wanted) < limit - codecs
    usable = [each for each in asked if each.is_wanted or room]
    if first.is_wanted or len(wanted) < limit:
        usable.append(first)
    usable += [each for each in wanted if each.mime_type == first.mime_type]
    if not usable:
        raise NoEncoder(f"all {limit} encoders are in use, and none encodes {first.mime_type}: try again later")
    return tuple(each if each in usable else min(usable, key=lambda other: _distance(each, other)) for each in asked)


def _is_first(rendition: Encodable) -> bool:
    return rendition.rung is not None and rendition.rung.halvings == 0 and rendition.rung.every == 1


def _distance(one: Encodable, other: Encodable) -> float:
    """Return how far apart two renditions are, in size and in pace: both are visible."""
    if one.rung is None or other.rung is None:
        return inf
    size = log(one.rung.width * one.rung.height / (other.rung.width * other.rung.height))
    return abs(size) + abs(log(one.rung.frame_rate / other.rung.frame_rate))
