"""The analysis of one camera: from pictures, one after the other, to who is seen. It blocks; it runs in a thread."""

import math
from dataclasses import dataclass, field
from typing import Final

from openrois_avatar.vision.backends import FaceFinder, FaceRecognizer, Followed, GestureReader
from openrois_avatar.vision.box import place_of
from openrois_avatar.vision.flow import motions
from openrois_avatar.vision.gallery import Gallery, Likeness, Opinion
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
    """Who somebody is taken for, and when that was looked at."""

    opinion: Opinion = field(default_factory=Opinion)
    looked_at: float = -math.inf


class Analysis:
    """Finds, follows, places and recognises whoever is in the pictures of one camera.

    Args:
        finder: finds faces.
        recognizer: tells them apart.
        reader: reads their gestures.
        gallery: who is known.
    """

    def __init__(self, finder: FaceFinder, recognizer: FaceRecognizer, reader: GestureReader, gallery: Gallery) -> None:
        self.collects = False
        """Whether somebody wants to have the likenesses, for enrolment; set from another thread."""
        self._finder = finder
        self._recognizer = recognizer
        self._reader = reader
        self._gallery = gallery
        self._tracks = Tracks()
        self._memories: dict[int, _Memory] = {}
        self._before: View | None = None

    def forget(self) -> None:
        """Begin anew, with other numbers; in the thread that looks."""
        self._tracks = self._tracks.successor()
        self._before = None

    def look(self, view: View) -> Seen:
        """Return who is in the next picture."""
        if self._before is None or not _follows(self._before, view):
            self.forget()
        followed = self._follow(view)
        gestures = self._reader.read(view, followed)
        self._tracks.take(self._finder.find(view, self._tracks.known), view.moment)
        self._memories = {number: self._memories.get(number) or _Memory() for number in self._tracks.numbers}
        persons = tuple(self._person(track, view, gestures.get(track.number)) for track in self._tracks.confirmed)
        return Seen(view.moment, persons)

    def _follow(self, view: View) -> list[Followed]:
        """Move everybody as the picture did since the last one."""
        before, self._before = self._before, view
        if before is None:
            return []
        moved = motions(before.grey, view.grey, self._tracks.known)
        self._tracks.move(moved)
        return [
            Followed(number, face, motion)
            for number, face, motion in zip(self._tracks.numbers, self._tracks.known, moved, strict=True)
        ]

    def _person(self, track: Track, view: View, gesture: str | None) -> Person:
        memory, likeness = self._memories[track.number], None
        if track.found_at == view.moment and (self.collects or self._gallery.names):
            likeness = self._likeness(track, memory, view)
        name = memory.opinion.name
        return Person(
            track.number,
            track.face.box,
            place_of(track.face.box, view.aspect),
            track.shows_face(view.moment),
            name if name in self._gallery.names else None,  # it may have been forgotten since
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


def _follows(before: View, view: View) -> bool:
    """Whether a picture shows what the one before it did, a little later."""
    return before.grey.shape == view.grey.shape and 0 <= view.moment - before.moment <= _GAP
