"""Limit on the renditions of all sources that are encoded at a time, and their substitutes. Pure."""

from collections.abc import Callable, Iterable, Sequence
from math import inf, log
from typing import Final, Protocol, TypeVar

from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.errors import NoEncoder

ENCODERS_LIMIT: Final = 6
"""Default number of encoders at a time: three sizes of one source in two codecs, or three sources in one size."""


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


class EncoderLimit:
    """Limit on the encoders of the sources that share it.

    Args:
        limit: how many may run at a time.
    """

    def __init__(self, limit: int = ENCODERS_LIMIT) -> None:
        self.limit = limit
        self._sources: list[Callable[[], Iterable[Encodable]]] = []

    def add_source(self, made: Callable[[], Iterable[Encodable]]) -> None:
        """Count the encoders of a source, of which `made` returns all renditions."""
        self._sources.append(made)

    def choose(self, asked: Sequence[T], first: T, made: Iterable[T], codecs: int) -> tuple[T, ...]:
        """Return the renditions that a viewer of a source can have; as `within_limit`."""
        everywhere = [each for source in self._sources for each in source()]
        return within_limit(asked, first, made, everywhere, self.limit, codecs * len(self._sources))


def within_limit(
    asked: Sequence[T], first: T, made: Iterable[T], everywhere: Iterable[Encodable], limit: int, reserved: int
) -> tuple[T, ...]:
    """Return the renditions that a viewer can have in place of those that suit it.

    An encoder is reserved for the first rendition of each source and codec, the largest at the full pace: whatever
    other viewers ask for, it stays available. Where no encoder is left, the nearest running rendition replaces the one
    that would need another.

    Args:
        asked: renditions of one codec that suit the viewer.
        first: the first rendition of that codec.
        made: all renditions of the source.
        everywhere: all renditions of all sources.
        limit: how many may be encoded at a time.
        reserved: how many first renditions there are: one for each source and codec.

    Raises:
        NoEncoder: not even the first one can be encoded; only where there are fewer encoders than first renditions.
    """
    running = [each for each in everywhere if each.is_wanted]
    room = sum(not _is_first(each) for each in running) < limit - reserved
    usable = [each for each in asked if each.is_wanted or room]
    if first.is_wanted or len(running) < limit:
        usable.append(first)
    usable += [each for each in made if each.is_wanted and each.mime_type == first.mime_type]
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
