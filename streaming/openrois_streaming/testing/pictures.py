"""Figures of the pictures that a viewer has received: number, delay, gaps and freezes. Pure."""

from collections import deque
from dataclasses import dataclass

from openrois_streaming.source.stamp import NUMBER_MODULUS, Stamp
from openrois_streaming.testing.delays import Delays

KEPT = 20_000
"""Number of newest delays for percentiles: more than ten minutes at 30 pictures a second."""

SIZES_KEPT = 100

_FREEZE_FACTOR, _FREEZE_EXTRA, _FREEZE_AVERAGE = 3.0, 0.150, 30


@dataclass(frozen=True, slots=True)
class SeenPicture:
    """Picture that was decoded at `at` (seconds of the media clock), which was `wall` (epoch seconds).

    `stamp` was read in it; None if there was none.
    """

    at: float
    wall: float
    width: int
    height: int
    stamp: Stamp | None

    @property
    def delay(self) -> float | None:
        """Seconds from its capture until it was decoded; None without a stamp."""
        return None if self.stamp is None else self.stamp.age(self.wall)


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureFigures:
    """Figures of pictures since the count began.

    Attributes:
        seconds: since then.
        pictures: that were decoded.
        key_frames: that arrived, decoded or not.
        unreadable: those of them without a stamp that could be read.
        missed: numbers missing between two pictures: lost, dropped, or not captured.
        repeated: pictures with the number of the one before, or an earlier one.
        freezes: gaps between pictures of at least three times the average of the last 30, and 150 ms more than it
            (`freezeCount` of W3C's webrtc-stats); one that lasts is counted.
        frozen: seconds of them all.
        longest_gap: seconds between two pictures, or since the last one, at most.
        size: width and height of the last picture; None before the first.
        size_changes: number of changes of the size.
        delay: from capture to decoded; None if no stamp was read.
    """

    seconds: float
    pictures: int
    key_frames: int
    unreadable: int
    missed: int
    repeated: int
    freezes: int
    frozen: float
    longest_gap: float
    size: tuple[int, int] | None
    size_changes: int
    delay: Delays | None

    @property
    def fps(self) -> float:
        """Pictures per second."""
        return self.pictures / self.seconds if self.seconds > 0 else 0.0


class PictureLog:
    """Log of pictures. Its memory is bounded: `KEPT` delays, and the last `SIZES_KEPT` changes of the size.

    Args:
        now: when the count begins, in seconds of the media clock.
    """

    def __init__(self, now: float) -> None:
        self._gaps: deque[float] = deque(maxlen=_FREEZE_AVERAGE)
        self.last: SeenPicture | None = None
        """The newest picture."""
        self.count = 0
        """Number of pictures since the log was made."""
        self.restart(now)

    def restart(self, now: float) -> None:
        """Restart the count; pictures missing between the last and the next one belong to the new count."""
        self._since = now
        self._pictures = self._unreadable = self._missed = self._repeated = 0
        self._freezes, self._frozen, self._longest = 0, 0.0, 0.0
        self._delays: deque[float] = deque(maxlen=KEPT)
        self._changes = 0
        self.sizes: deque[tuple[float, int, int]] = deque(maxlen=SIZES_KEPT)
        """When the size changed, and to which width and height."""

    def add(self, picture: SeenPicture) -> None:
        """Add a picture; they come in the order in which they were decoded."""
        before, self.last = self.last, picture
        self.count += 1
        self._pictures += 1
        if picture.delay is None:
            self._unreadable += 1
        else:
            self._delays.append(picture.delay)
        if before is None:
            self.sizes.append((picture.at, picture.width, picture.height))
            return
        if (picture.width, picture.height) != (before.width, before.height):
            self._changes += 1
            self.sizes.append((picture.at, picture.width, picture.height))
        self._count_numbers(before.stamp, picture.stamp)
        gap = picture.at - before.at
        self._longest = max(self._longest, self._within(before, picture.at))
        if self._is_freeze(gap):
            self._freezes += 1
            self._frozen += self._within(before, picture.at)
        self._gaps.append(gap)

    def figures(self, now: float, key_frames: int = 0) -> PictureFigures:
        """Return the figures up to `now`, a lasting gap included; the key frames were counted elsewhere."""
        freezes, frozen, longest = self._freezes, self._frozen, self._longest
        if self.last is not None:
            longest = max(longest, self._within(self.last, now))
            if self._is_freeze(now - self.last.at):
                freezes, frozen = freezes + 1, frozen + self._within(self.last, now)
        return PictureFigures(
            seconds=now - self._since,
            pictures=self._pictures,
            key_frames=key_frames,
            unreadable=self._unreadable,
            missed=self._missed,
            repeated=self._repeated,
            freezes=freezes,
            frozen=frozen,
            longest_gap=longest,
            size=None if self.last is None else (self.last.width, self.last.height),
            size_changes=self._changes,
            delay=Delays.of(self._delays),
        )

    def _count_numbers(self, before: Stamp | None, after: Stamp | None) -> None:
        if before is None or after is None:
            return
        step = (after.number - before.number) % NUMBER_MODULUS
        if step == 0 or step > NUMBER_MODULUS // 2:
            self._repeated += 1
        else:
            self._missed += step - 1

    def _within(self, before: SeenPicture, now: float) -> float:
        """Return the seconds from a picture, or from the start of the count if that is later, to `now`."""
        return now - max(before.at, self._since)

    def _is_freeze(self, gap: float) -> bool:
        if not self._gaps:
            return False
        average = sum(self._gaps) / len(self._gaps)
        return gap >= max(_FREEZE_FACTOR * average, average + _FREEZE_EXTRA)
