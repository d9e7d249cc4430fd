"""Tracks of faces: a person keeps a number from picture to picture, also while the face is not found. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from openrois_body.vision.box import Face, Motion

__all__ = ["FACE_MEMORY", "MAX_TRACKS", "PERSON_MEMORY", "Track", "Tracks"]

FACE_MEMORY: Final = 0.7
"""Seconds for which a face counts as seen after it was found last: a finder misses some."""
PERSON_MEMORY: Final = 2.0
"""Seconds for which a person counts as there after their face was found last: they look away, or bend down."""
MAX_TRACKS: Final = 10
"""Persons that are tracked at a time; others are ignored."""
_CONFIRMED: Final = 3
"""Times that a face has to be found before it is confirmed: false detections seldom repeat."""
_DOUBT: Final = 0.5
"""Seconds after which a face that was not found again is forgotten while it is not confirmed."""
_SAME: Final = 0.25
"""Overlap from which on two boxes are of the same face."""
_TRUST: Final = 0.4
"""Weight of the finder's box; the rest is the tracked motion, which is steadier."""


@dataclass(frozen=True, slots=True)
class Track:
    """The track of one person: a unique number, and the last known face."""

    number: int
    face: Face
    found_at: float
    hits: int = 1

    @property
    def is_confirmed(self) -> bool:
        """Whether the face was found often enough to be one."""
        return self.hits >= _CONFIRMED

    def shows_face(self, now: float) -> bool:
        """Tell whether the face is seen now."""
        return now - self.found_at <= FACE_MEMORY

    def is_over(self, now: float) -> bool:
        """Tell whether the person has gone, or never was."""
        return now - self.found_at > (PERSON_MEMORY if self.is_confirmed else _DOUBT)


class Tracks:
    """All tracks, in the order of their first faces. For each picture: `move`, then `update`.

    Args:
        last: the highest number that was given before.
    """

    def __init__(self, last: int = 0) -> None:
        self._tracks: list[Track] = []
        self._last = last

    @property
    def known(self) -> list[Face]:
        """All tracked faces, confirmed or not."""
        return [track.face for track in self._tracks]

    @property
    def confirmed(self) -> list[Track]:
        """The confirmed tracks."""
        return [track for track in self._tracks if track.is_confirmed]

    @property
    def numbers(self) -> list[int]:
        """The number of each of `known`."""
        return [track.number for track in self._tracks]

    def successor(self) -> "Tracks":
        """Return empty tracks that continue the numbers, for a picture of another scene."""
        return Tracks(self._last)

    def move(self, motions: Sequence[Motion | None]) -> None:
        """Move each of `known`; None where its motion is not known."""
        self._tracks = [
            track if motion is None else replace(track, face=track.face.moved(motion))
            for track, motion in zip(self._tracks, motions, strict=True)
        ]

    def update(self, found: Sequence[Face], now: float) -> None:
        """Match the faces that were found in the picture of `now` with the tracks; unmatched faces are new."""
        pairs = sorted(
            (
                (overlap, index, which)
                for index, track in enumerate(self._tracks)
                for which, face in enumerate(found)
                if (overlap := track.face.box.overlap(face.box)) >= _SAME
            ),
            reverse=True,
        )
        # A face that overlaps with a track is not new, even if another face is the better match.
        strangers = [face for which, face in enumerate(found) if which not in {pair[2] for pair in pairs}]
        met: set[int] = set()
        used: set[int] = set()
        for _overlap, index, which in pairs:
            if index not in met and which not in used:
                met.add(index)
                used.add(which)
                self._tracks[index] = _found_again(self._tracks[index], found[which], now)
        self._tracks = [track for track in self._tracks if not track.is_over(now)]
        self._welcome(strangers, now)

    def _welcome(self, strangers: Sequence[Face], now: float) -> None:
        for face in strangers[: MAX_TRACKS - len(self._tracks)]:
            self._last += 1
            self._tracks.append(Track(self._last, face, now))


def _found_again(track: Track, face: Face, now: float) -> Track:
    known = track.face
    roll = known.roll + (face.roll - known.roll) * _TRUST
    return replace(track, face=Face(known.box.between(face.box, _TRUST), roll), found_at=now, hits=track.hits + 1)
