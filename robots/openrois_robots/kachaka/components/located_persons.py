"""PersonLocalization of persons that the robot detects: those alone whose distance it could measure (component 3)."""

from dataclasses import replace
from datetime import datetime

from openrois_body.components import persons
from openrois_body.vision.sighting import Refs, Sighting

from openrois_robots.kachaka.detection import Detection
from openrois_robots.kachaka.persons import is_located

__all__ = ["PersonLocalization"]


class PersonLocalization(persons.PersonLocalization):
    """Announces where on the robot's map the persons are that it detects.

    A person whose distance the robot cannot measure, as on its charger, is counted by PersonDetection and has no place.

    Args:
        detection: of the robot.
        refs: makes the refs of persons.
    """

    def __init__(self, detection: Detection, refs: Refs) -> None:
        super().__init__(detection, refs)
        self._detection = detection

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce movements beyond the threshold."""
        places = ((person, self._detection.locate(person.place)) for person in seen.persons if is_located(person))
        located = tuple(replace(person, place=place) for person, place in places if place is not None)
        super().sense(replace(seen, persons=located), moment)
