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

    Each source that is watched has one encoder for each codec that is watched, as many as there are; what is left goes
    to further sizes and paces. Such an encoder gives way when another source or codec comes to be watched: its viewers
    share the nearest that runs. Until they have changed, for about a second, more than `limit` may run.

    Args:
        limit: how many may run at a time.
    """

    def __init__(self, limit: int = ENCODERS_LIMIT) -> None:
        self.limit = limit
        self._sources: list[Callable[[], Iterable[Encodable]]] = []

    def add_source(self, made: Callable[[], Iterable[Encodable]]) -> None:
        """Count the encoders of a source, of which `made` returns all renditions."""
        self._sources.append(made)

    def choose(self, asked: Sequence[T], first: T, made: Iterable[T]) -> tuple[T, ...]:
        """Return the renditions that a viewer of a source can have; as `within_limit`."""
        own = [each for each in made if each.is_wanted and each.mime_type == first.mime_type]
        everywhere = [group for source in self._sources for group in _by_codec(source())]
        return within_limit(asked, first, own, everywhere, self.limit)


def within_limit(
    asked: Sequence[T], first: T, own: Sequence[T], everywhere: Sequence[Sequence[Encodable]], limit: int
) -> tuple[T, ...]:
    """Return the renditions that a viewer can have in place of those that suit it.

    The first rendition of its codec, the largest at the full pace, is always one of them. Where no encoder is left, the
    nearest of what it can have replaces each other one.

    Args:
        asked: renditions of one codec that suit the viewer.
        first: the first rendition of that codec.
        own: running renditions of the same source and codec.
        everywhere: running renditions of all sources, those of each source and codec together.
        limit: how many may be encoded at a time.

    Raises:
        NoEncoder: as many sources and codecs are watched as there may be encoders, and this one is not among them.
    """
    if not own and len(everywhere) >= limit:
        raise NoEncoder(
            f"all {limit} encoders are in use, and none encodes {first.mime_type} of this source:"
            " disconnect another stream, or raise max_encoders of the adapter"
        )
    running = sum(map(len, everywhere))
    if own and running >= limit:
        ending = _giving_way(everywhere, running - limit)
        usable = [first, *(each for each in own if each not in ending)]
    else:
        usable = [first, *own, *asked]
    return tuple(each if each in usable else min(usable, key=lambda other: _distance(each, other)) for each in asked)


def _by_codec(made: Iterable[Encodable]) -> list[list[Encodable]]:
    """Return the running renditions of a source, those of each codec together."""
    groups: dict[str, list[Encodable]] = {}
    for each in made:
        if each.is_wanted:
            groups.setdefault(each.mime_type, []).append(each)
    return list(groups.values())


def _giving_way(groups: Sequence[Sequence[Encodable]], count: int) -> list[Encodable]:
    """Return `count` running renditions that give way, the same ones for all viewers.

    One of each group stays, the largest at the greatest pace. Of the others those end first that differ least from
    another of their group: their viewers notice it least.
    """
    spare: list[tuple[float, Encodable]] = []
    for group in groups:
        kept = max(group, key=_weight)
        for each in group:
            if each is not kept:
                spare.append((min(_distance(each, other) for other in group if other is not each), each))
    spare.sort(key=lambda entry: entry[0])
    return [each for _, each in spare[:count]]


def _weight(rendition: Encodable) -> float:
    """Return the pixels that a rendition has in a second."""
    rung = rendition.rung
    return 0.0 if rung is None else rung.width * rung.height * rung.frame_rate


def _distance(one: Encodable, other: Encodable) -> float:
    """Return how far apart two renditions are, in size and in pace: both are visible."""
    if one.rung is None or other.rung is None:
        return inf
    size = log(one.rung.width * one.rung.height / (other.rung.width * other.rung.height))
    return abs(size) + abs(log(one.rung.frame_rate / other.rung.frame_rate))
