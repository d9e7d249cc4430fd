"""The senses of the operator's camera: six components of the standard and two of OpenRoIS, on one watch."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from openrois_media.devices import Camera
from openrois_streaming.clock import MediaClock

from openrois.component.component import Component
from openrois_body.backends import chosen
from openrois_body.components.enrolment import Enrolment
from openrois_body.components.faces import FaceDetection, FaceLocalization
from openrois_body.components.gesture_recognition import GestureRecognition
from openrois_body.components.persons import PersonDetection, PersonIdentification, PersonLocalization
from openrois_body.components.sight import Sight
from openrois_body.vision.analysis import Analysis
from openrois_body.vision.backends import FINDERS, GESTURE_READERS, RECOGNIZERS
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.gallery import Gallery
from openrois_body.vision.head_reader import HeadReader
from openrois_body.vision.patterns import PatternRecognizer
from openrois_body.vision.sighting import Refs
from openrois_body.vision.watch import Locate, Watch

__all__ = ["CameraSenses", "camera_senses"]


@dataclass(frozen=True, slots=True)
class CameraSenses:
    """The components and the watch that they share; `run` has to run."""

    components: tuple[Component, ...]
    watch: Watch

    def run(self) -> Coroutine[Any, Any, None]:
        """Analyse pictures until cancelled, while a sense is active."""
        return self.watch.run()


def camera_senses(
    engine_id: str,
    camera: Camera,
    clock: MediaClock,
    *,
    locate: Locate | None = None,
    camera_problem: Callable[[], str] = lambda: "",
) -> CameraSenses:
    """Return the senses of a camera, with the best backends that are installed.

    Args:
        engine_id: leads every ref.
        camera: source of the pictures.
        clock: the media clock.
        locate: tells where on the floor persons are; None: their places are in the axes of the camera.
        camera_problem: returns why the camera has no pictures; empty where it has, or where they may come any time.
    """
    finder, recognizer = chosen(FINDERS, CascadeFinder), chosen(RECOGNIZERS, PatternRecognizer)
    reader = chosen(GESTURE_READERS, HeadReader)
    gallery, refs = Gallery(), Refs(engine_id)
    works, reason = finder.available()
    watch = Watch(
        camera,
        clock,
        Analysis(finder, recognizer, reader, gallery),
        "" if works else reason,
        locate=locate,
        camera_problem=camera_problem,
    )
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
