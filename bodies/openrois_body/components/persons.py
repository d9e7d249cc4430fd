"""PersonDetection, PersonLocalization and PersonIdentification (components 2 to 4) on the operator's camera."""

from datetime import datetime

from openrois.adapter import components
from openrois_body.components.camera_sense import CameraSense, SightingSource
from openrois_body.components.sensing import Localizing
from openrois_body.sensing.changes import Numbers
from openrois_body.vision.sighting import Refs, Sighting

__all__ = ["PersonDetection", "PersonIdentification", "PersonLocalization"]


class PersonDetection(CameraSense, components.PersonDetection):
    """Announces how many persons are in front of the camera, when that changes: their faces were seen not long ago.

    Args:
        watch: sees persons.
    """

    def __init__(self, watch: SightingSource) -> None:
        super().__init__(watch)
        self._numbers = Numbers()

    def begin(self) -> None:
        """Announce the number again, and 0 where it was another one."""
        self._numbers.begin()

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce a changed number of persons."""
        if self._numbers.is_news(len(seen.persons)):
            self.person_detected(len(seen.persons), moment)


class PersonLocalization(CameraSense, Localizing, components.PersonLocalization):
    """Announces where the persons are: the last place of each face, an estimate from its size in the picture.

    Places are on the floor of the body where it is known where its camera is, else in the axes of the camera.

    Args:
        watch: sees persons.
        refs: makes the refs of persons.
    """

    def __init__(self, watch: SightingSource, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs

    def begin(self) -> None:
        """Forget the persons that were announced."""
        self.forget_places()

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce movements beyond the threshold."""
        places = {self._refs.person(person): person.place for person in seen.persons}
        if self.is_news(places, seen.moment):
            self.person_localized(tuple(places), tuple(place.text for place in places.values()), moment)


class PersonIdentification(CameraSense, components.PersonIdentification):
    """Announces which enrolled persons are there, when one more is recognised.

    Args:
        watch: sees persons.
        refs: makes the refs of enrolled persons.
    """

    def __init__(self, watch: SightingSource, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs
        self._known: frozenset[str] = frozenset()

    def begin(self) -> None:
        """Forget the persons that were announced."""
        self._known = frozenset()

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce all recognised persons, when a new one is among them."""
        before, self._known = self._known, frozenset(person.name for person in seen.persons if person.name)
        if self._known - before:
            self.person_identified(tuple(self._refs.known(name) for name in sorted(self._known)), moment)
