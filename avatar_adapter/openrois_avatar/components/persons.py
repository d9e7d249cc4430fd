"""PersonDetection, PersonLocalization and PersonIdentification (components 2 to 4) on the operator's camera."""

from datetime import datetime

from openrois.adapter import components
from openrois_avatar.components.camera_sense import CameraSense
from openrois_avatar.components.sensing import Localizing
from openrois_avatar.sensing.changes import Numbers
from openrois_avatar.vision.seen import Refs, Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["PersonDetection", "PersonIdentification", "PersonLocalization"]


class PersonDetection(CameraSense, components.PersonDetection):
    """Tells how many persons are in front of the camera, when that changes: whose face was seen, and not long ago.

    Args:
        watch: what looks at the camera.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__(watch)
        self._numbers = Numbers()

    def begin(self) -> None:
        """Tell the number again, and 0 where it was another one."""
        self._numbers.begin()

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell another number of persons."""
        if self._numbers.tells(len(seen.persons)):
            self.person_detected(len(seen.persons), moment)


class PersonLocalization(CameraSense, Localizing, components.PersonLocalization):
    """Tells where the persons are: where their faces were last, an estimate from the size in the picture.

    Args:
        watch: what looks at the camera.
        refs: how persons are called.
    """

    def __init__(self, watch: Watch, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs

    def begin(self) -> None:
        """Begin with nobody."""
        self.forget_places()

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell movements that are far enough."""
        places = {self._refs.person(person): person.place for person in seen.persons}
        if self.tells(places, seen.moment):
            self.person_localized(tuple(places), tuple(place.text for place in places.values()), moment)


class PersonIdentification(CameraSense, components.PersonIdentification):
    """Tells who is there, of those that were enrolled, when a person is recognised who was not there before.

    Args:
        watch: what looks at the camera.
        refs: how those who are enrolled are called.
    """

    def __init__(self, watch: Watch, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs
        self._known: frozenset[str] = frozenset()

    def begin(self) -> None:
        """Begin with nobody."""
        self._known = frozenset()

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell everybody who is recognised, when somebody new is among them."""
        before, self._known = self._known, frozenset(person.name for person in seen.persons if person.name)
        if self._known - before:
            self.person_identified(tuple(self._refs.known(name) for name in sorted(self._known)), moment)
