"""The analysis of one camera: from pictures, one after the other, to who is seen. It blocks; it runs in a thread."""

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrois_avatar.vision.backends import FaceFinder, FaceRecognizer
from openrois_avatar.vision.box import Motion, place_of
from openrois_avatar.vision.flow import motions
from openrois_avatar.vision.gallery import Gallery, Likeness, Opinion
from openrois_avatar.vision.head_gestures import Gesture, HeadGestures
from openrois_avatar.vision.seen import Person, Seen
from openrois_avatar.vision.tracks import Track, Tracks
from openrois_avatar.vision.view import View

__all__ = ["Analysis"]

_GAP: Final = 1.0
"""Seconds without a picture after which the next one has nothing to do with the last."""
_RECOGNITION: Final = 0.4
"""Seconds between two looks at who somebody is."""


@dataclass(slots=True)
class _Memory:
    """What is known of one person beside the track."""

    gestures: HeadGestures = field(default_factory=HeadGestures)
    opinion: Opinion = field(default_factory=Opinion)
    looked_at: float = -math.inf


class Analysis:
    """Finds, follows, places and recognises whoever is in the pictures of one camera.

    Args:
        finder: finds faces.
        recognizer: tells them apart.
        gallery: who is known.
    """

    def __init__(self, finder: FaceFinder, recognizer: FaceRecognizer, gallery: Gallery) -> None:
        self.collects = False
        """Whether somebody wants to have the likenesses, for enrolment; set from another thread."""
        self._finder = finder
        self._recognizer = recognizer
        self._gallery = gallery
        self._tracks = Tracks()
        self._memories: dict[int, _Memory] = {}
        self._before: NDArray[np.uint8] | None = None
        self._before_at = -math.inf

    def look(self, view: View) -> Seen:
        """Return who is in the next picture."""
        moved = self._follow(view)
        self._tracks.take(self._finder.find(view, self._tracks.known), view.moment)
        numbers = self._tracks.numbers
        self._memories = {number: self._memories.get(number) or _Memory() for number in numbers}
        gestures = {number: self._gesture(number, motion, view.moment) for number, motion in moved.items()}
        return Seen(
            view.moment,
            tuple(self._person(track, view, gestures.get(track.number)) for track in self._tracks.confirmed),
        )

    def _follow(self, view: View) -> dict[int, Motion]:
        """Move everybody as the picture did since the last one; return the motions by number."""
        before, self._before = self._before, view.grey
        gap, self._before_at = view.moment - self._before_at, view.moment
        if before is None or before.shape != view.grey.shape or not 0 <= gap <= _GAP:
            self._tracks = self._tracks.successor()
            return {}
        numbers, faces = self._tracks.numbers, self._tracks.known
        moved = motions(before, view.grey, faces)
        self._tracks.move(moved)
        return {
            number: Motion(motion.x / face.box.width, motion.y / face.box.height, motion.scale, motion.roll)
            for number, face, motion in zip(numbers, faces, moved, strict=True)
            if motion is not None
        }

    def _gesture(self, number: int, motion: Motion, moment: float) -> Gesture | None:
        memory = self._memories.get(number)
        return None if memory is None else memory.gestures.take(moment, motion.x, motion.y, motion.roll)

    def _person(self, track: Track, view: View, gesture: Gesture | None) -> Person:
        memory, likeness = self._memories[track.number], None
        if track.found_at == view.moment and (self.collects or self._gallery.names):
            likeness = self._likeness(track, memory, view)
        return Person(
            track.number,
            track.face.box,
            place_of(track.face.box, view.aspect),
            track.shows_face(view.moment),
            memory.opinion.name,
            gesture,
            likeness if self.collects else None,
        )

    def _likeness(self, track: Track, memory: _Memory, view: View) -> Likeness | None:
        if not self.collects and view.moment - memory.looked_at < _RECOGNITION:
            return None
        memory.looked_at = view.moment
        likeness = self._recognizer.likeness(view, track.face)
        if likeness is not None:
            memory.opinion.take(self._gallery.who(likeness, self._recognizer.limit))
        return likeness
