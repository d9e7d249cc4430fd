"""The seventeen basic components, in the standard's order."""

from typing import Final

from openrois.catalog.actuation import FOLLOW, MOVE, NAVIGATION, REACTION, SPEECH_SYNTHESIS
from openrois.catalog.component_type import ComponentType
from openrois.catalog.sensing import (
    FACE_DETECTION,
    FACE_LOCALIZATION,
    GESTURE_RECOGNITION,
    PERSON_DETECTION,
    PERSON_IDENTIFICATION,
    PERSON_LOCALIZATION,
    SOUND_DETECTION,
    SOUND_LOCALIZATION,
    SPEECH_RECOGNITION,
)
from openrois.catalog.streaming import AUDIO_STREAMING, VIDEO_STREAMING
from openrois.catalog.system_information import SYSTEM_INFORMATION

__all__ = ["BASIC_COMPONENTS"]

BASIC_COMPONENTS: Final[tuple[ComponentType, ...]] = (
    SYSTEM_INFORMATION,
    PERSON_DETECTION,
    PERSON_LOCALIZATION,
    PERSON_IDENTIFICATION,
    FACE_DETECTION,
    FACE_LOCALIZATION,
    SOUND_DETECTION,
    SOUND_LOCALIZATION,
    SPEECH_RECOGNITION,
    GESTURE_RECOGNITION,
    SPEECH_SYNTHESIS,
    REACTION,
    NAVIGATION,
    FOLLOW,
    MOVE,
    AUDIO_STREAMING,
    VIDEO_STREAMING,
)
