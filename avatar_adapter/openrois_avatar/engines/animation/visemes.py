"""Mouth shapes for speech: the fifteen of the Oculus set, and tracks of them with coarticulation."""

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Final

from openrois_avatar.engines.animation.curves import smooth
from openrois_avatar.engines.animation.pose import Mouth

SHAPES: Final[Mapping[str, Mouth]] = {
    "sil": Mouth(),
    "PP": Mouth(press=1.0, jaw=0.02),
    "FF": Mouth(bite=1.0, upper=0.40, jaw=0.08),
    "TH": Mouth(jaw=0.20, tongue=1.0, wide=0.15, upper=0.25, lower=0.20),
    "DD": Mouth(jaw=0.20, tongue=0.55, wide=0.20, upper=0.35, lower=0.35),
    "kk": Mouth(jaw=0.30, wide=0.10, upper=0.20, lower=0.25),
    "CH": Mouth(jaw=0.14, round=0.60, upper=0.75, lower=0.75),
    "SS": Mouth(jaw=0.07, wide=0.60, upper=0.50, lower=0.55),
    "nn": Mouth(jaw=0.14, tongue=0.40, wide=0.10, upper=0.15, lower=0.30),
    "RR": Mouth(jaw=0.22, round=0.50, upper=0.35, lower=0.25),
    "aa": Mouth(jaw=1.0, upper=0.25, lower=0.45, wide=0.12),
    "E": Mouth(jaw=0.50, wide=0.65, upper=0.40, lower=0.35),
    "ih": Mouth(jaw=0.28, wide=0.80, upper=0.40, lower=0.30),
    "oh": Mouth(jaw=0.66, round=0.70, lower=0.25),
    "ou": Mouth(jaw=0.30, round=1.0, lower=0.20),
}
"""The mouth shape of each viseme at full weight."""

_SPREAD: Final = 0.11
"""Seconds of the transition from one shape to the next: lips start early and leave late."""
EARLY: Final = 0.02
"""Seconds by which lips are ahead of the sound: closed lips dominate, and would open too late without this."""
_FIRMNESS: Final[Mapping[str, float]] = {
    "PP": 4.0,
    "FF": 3.0,
    "TH": 1.6,
    "CH": 1.6,
    "SS": 1.4,
    "ou": 1.4,
    "kk": 0.6,
    "nn": 0.8,
    "sil": 0.8,
}
"""Dominance of a shape over its neighbours, 1 unless listed: closed lips must close, the tongue's back is hidden."""
_VOWELS: Final = frozenset(("aa", "E", "ih", "oh", "ou"))
_ACCENT_GAP: Final = 0.50
"""Seconds between two accents, at least."""
_ACCENT_LENGTH: Final = 0.42
CUT: Final = 0.08
"""Seconds in which the mouth closes on `Silence`."""
PARTS: Final = tuple(part.name for part in fields(Mouth))


@dataclass(frozen=True, slots=True)
class Voiced:
    """One viseme of a track, with its place in time (seconds of the track) and weight 0..1."""

    start: float
    end: float
    shape: str
    weight: float


@dataclass(frozen=True, slots=True)
class Share:
    """A track's contribution to the mouth at a moment: shape times firmness, firmness, and presence."""

    shape: tuple[float, ...]
    firmness: float
    presence: float


class Track:
    """Visemes from an absolute start on, until the duration or a cut ends them.

    Args:
        start: when the sound starts, in the animation's seconds.
        visemes: (offset in seconds, name, weight), in order; each lasts until the next one.
        duration: seconds after which the mouth is at rest.
    """

    def __init__(self, start: float, visemes: Sequence[tuple[float, str, float]], duration: float) -> None:
        self.start, self.end = start, start + duration
        ends = [*(offset for offset, _, _ in visemes), duration][1:]
        self._voiced = [
            Voiced(offset, min(end, duration), shape, weight)
            for (offset, shape, weight), end in zip(visemes, ends, strict=True)
            if offset < duration
        ]
        self._starts = [voiced.start for voiced in self._voiced]
        self._ends = [voiced.end for voiced in self._voiced]
        self._accents = _accents(self._voiced)
        self._cut: float | None = None

    def cut(self, time: float) -> None:
        """Close the mouth from this time on."""
        if self._cut is None and time < self.end:
            self._cut = time

    def is_spoken(self, time: float) -> bool:
        """Return whether the track is being spoken at a time: it has begun, and is neither at its end nor cut."""
        return self.start <= time < (self.end if self._cut is None else self._cut)

    def over(self, time: float) -> bool:
        """Return whether the track has no effect any more."""
        last = self.end + _ACCENT_LENGTH if self._cut is None else self._cut + CUT
        return time > last + _SPREAD

    def share(self, time: float) -> Share:
        """Return the track's contribution to the mouth at a time."""
        at, loudness = time - self.start + EARLY, self._loudness(time)
        first, last = bisect_left(self._ends, at - _SPREAD / 2), bisect_right(self._starts, at + _SPREAD / 2)
        total, firmness, presence = [0.0] * len(PARTS), 0.0, 0.0
        for voiced in self._voiced[first:last]:
            amount = (_risen(at - voiced.start) - _risen(at - voiced.end)) * loudness
            firm = amount * _FIRMNESS.get(voiced.shape, 1.0)
            firmness += firm
            presence += amount
            shape = SHAPES[voiced.shape]
            for index, name in enumerate(PARTS):
                total[index] += firm * voiced.weight * getattr(shape, name)
        return Share(tuple(total), firmness, presence)

    def accent(self, time: float) -> float:
        """Return how strongly head and brows stress the speech, 0..1."""
        at = time - self.start
        index = bisect_right(self._accents, at) - 1
        if index < 0:
            return 0.0
        part = (at - self._accents[index]) / _ACCENT_LENGTH
        return smooth(part / 0.35) * (1 - smooth((part - 0.35) / 0.65)) * self._loudness(time)

    def _loudness(self, time: float) -> float:
        return 1.0 if self._cut is None else 1 - smooth((time - self._cut) / CUT)


def blended(shares: Sequence[Share]) -> Mouth:
    """Return the mouth shape of several tracks; without any it is at rest."""
    rest = max(0.0, 1 - sum(share.presence for share in shares))
    firmness = rest + sum(share.firmness for share in shares)
    return Mouth(*(sum(share.shape[index] for share in shares) / firmness for index in range(len(PARTS))))


def mixed(mouth: Mouth, other: Mouth, share: float) -> Mouth:
    """Return a mouth shape with a share (0..1) of another one added."""
    return Mouth(*(getattr(mouth, part) + share * getattr(other, part) for part in PARTS))


def _risen(since: float) -> float:
    """Return the share of a shape that begins at 0."""
    return smooth(since / _SPREAD + 0.5)


def _accents(voiced: Sequence[Voiced]) -> list[float]:
    """Return the times of accents: at clear vowels, not too often, each a little ahead of its vowel."""
    times: list[float] = []
    for item in voiced:
        start = item.start - 0.06
        clear = item.shape in _VOWELS and item.weight * (item.end - item.start) > 0.05
        if clear and (not times or start - times[-1] >= _ACCENT_GAP):
            times.append(start)
    return times
