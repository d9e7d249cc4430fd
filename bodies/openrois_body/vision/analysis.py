"""The analysis of one camera: from successive pictures to persons. It blocks, and runs in a thread."""

import math
from dataclasses import dataclass, field
from typing import Final

from openrois_body.vision.backends import FaceFinder, FaceRecognizer, Followed, GestureReader
from openrois_body.vision.box import place_of
from openrois_body.vision.flow import motions
from openrois_body.vision.gallery import Gallery, Likeness, Opinion
from openrois_body.vision.sighting import Person, Sighting
from openrois_body.vision.tracks import Track, Tracks
from openrois_body.vision.view import View

__all__ = ["Analysis"]

_GAP: Final = 1.0
"""Seconds without a picture after which tracking begins anew."""
_RECOGNITION: Final = 0.4
"""Seconds between two recognitions of a person."""


@dataclass(slots=True)
class _Memory:
    """The opinion on a person's identity, and when it was last updated."""

    opinion: Opinion = field(default_factory=Opinion)
    looked_at: float = -math.inf


class Analysis:
    """Finds, tracks, locates and recognises the persons in the pictures of one camera.

    Args:
        finder: finds faces.
        recognizer: tells them apart.
        reader: reads their gestures.
        gallery: the enrolled persons.
    """

    def __init__(self, finder: FaceFinder, recognizer: FaceRecognizer, reader: GestureReader, gallery: Gallery) -> None:
        self.collects = False
        """Whether an enrolment wants the likenesses; set from another thread."""
        self._finder = finder
        self._recognizer = recognizer
        self._reader = reader
        self._gallery = gallery
        self._tracks = Tracks()
        self._memories: dict[int, _Memory] = {}
        self._before: View | None = None

    def reset(self) -> None:
        """Begin anew, with other numbers; called in the analysis thread."""
        self._tracks = self._tracks.successor()
        self._before = None

    def analyse_view(self, view: View) -> Sighting:
        """Return the persons in the next picture."""
        if self._before is None or not _follows(self._before, view):
            self.reset()
        followed = self._follow(view)
        gestures = self._reader.read(view, followed)
        self._tracks.update(self._finder.find(view, self._tracks.known), view.moment)
        self._memories = {number: self._memories.get(number) or _Memory() for number in self._tracks.numbers}
        persons = tuple(self._person(track, view, gestures.get(track.number)) for track in self._tracks.confirmed)
        return Sighting(view.moment, persons, view.raw.sender)

    def _follow(self, view: View) -> list[Followed]:
        """Move each track as its face moved since the last picture."""
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
            memory.opinion.add_vote(self._gallery.identify(likeness, self._recognizer.limit))
        return likeness


def _follows(before: View, view: View) -> bool:
    """Return whether a picture continues the one before it."""
    is_alike = before.raw.sender == view.raw.sender and before.grey.shape == view.grey.shape
    return is_alike and 0 <= view.moment - before.moment <= _GAP
