"""The senses of the operator's camera put together: six components of the standard and two of ours, on one watch."""

from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any

from openrois_streaming.clock import MediaClock

from openrois.component.component import Component
from openrois_avatar.backends import chosen
from openrois_avatar.components.enrolment import Enrolment
from openrois_avatar.components.faces import FaceDetection, FaceLocalization
from openrois_avatar.components.gesture_recognition import GestureRecognition
from openrois_avatar.components.persons import PersonDetection, PersonIdentification, PersonLocalization
from openrois_avatar.components.sight import Sight
from openrois_avatar.devices import Camera
from openrois_avatar.vision.analysis import Analysis
from openrois_avatar.vision.backends import FINDERS, GESTURE_READERS, RECOGNIZERS
from openrois_avatar.vision.cascades import CascadeFinder
from openrois_avatar.vision.gallery import Gallery
from openrois_avatar.vision.head_reader import HeadReader
from openrois_avatar.vision.patterns import PatternRecognizer
from openrois_avatar.vision.seen import Refs
from openrois_avatar.vision.watch import Watch

__all__ = ["CameraSenses", "camera_senses"]


@dataclass(frozen=True, slots=True)
class CameraSenses:
    """The components, and the watch that they share, which has to `run`."""

    components: tuple[Component, ...]
    watch: Watch

    def run(self) -> Coroutine[Any, Any, None]:
        """Watch for ever, while anybody listens."""
        return self.watch.run()


def camera_senses(engine_id: str, camera: Camera, clock: MediaClock) -> CameraSenses:
    """Return the senses of a camera, with the best backends that are installed.

    Args:
        engine_id: leads every ref.
        camera: whose pictures.
        clock: the media clock.
    """
    finder, recognizer = chosen(FINDERS, CascadeFinder), chosen(RECOGNIZERS, PatternRecognizer)
    reader = chosen(GESTURE_READERS, HeadReader)
    gallery, refs = Gallery(), Refs(engine_id)
    works, reason = finder.available()
    watch = Watch(camera, clock, Analysis(finder, recognizer, reader, gallery), "" if works else reason)
    components = (
        PersonDetection(watch),
        PersonLocalization(watch, refs),
        PersonIdentification(watch, refs),
        FaceDetection(watch),
        FaceLocalization(watch, refs),
        GestureRecognition(watch, reader.gestures),
        Sight(watch, refs),
        Enrolment(watch, camera, gallery, refs),
    )
    return CameraSenses(components, watch)
