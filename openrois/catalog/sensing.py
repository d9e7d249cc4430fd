"""The basic components that sense (2 to 10): persons, faces, sounds, speech and gestures."""

from datetime import datetime
from typing import Annotated, Final

from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import ComponentType, EventType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.types.codes import ComponentFunction

__all__ = [
    "FACE_DETECTION",
    "FACE_LOCALIZATION",
    "GESTURE_RECOGNITION",
    "PERSON_DETECTION",
    "PERSON_IDENTIFICATION",
    "PERSON_LOCALIZATION",
    "SOUND_DETECTION",
    "SOUND_LOCALIZATION",
    "SPEECH_RECOGNITION",
    "FaceDetected",
    "FaceLocalized",
    "GestureRecognitionParameters",
    "GestureRecognized",
    "LocalizationParameters",
    "PersonDetected",
    "PersonIdentified",
    "PersonLocalized",
    "RecognizableLanguagesResult",
    "SoundDetected",
    "SoundLocalized",
    "SpeechInputFinished",
    "SpeechInputStarted",
    "SpeechRecognitionParameters",
    "SpeechRecognized",
]

Number = Annotated[int, Data("int", "M", "how many there are now")]
Timestamp = Annotated[datetime, Data("DateTime", "M", "when it was measured")]
References = Annotated[
    tuple[str, ...], Data("RoISIdentifier[]", "M", "who or what they are, with reference information")
]
Positions = Annotated[tuple[str, ...], Data("String[]", "M", "a position x,y,th for each ref")]


class PersonDetected(Payload):
    """The number of persons has changed."""

    number: Number
    timestamp: Timestamp


class FaceDetected(Payload):
    """The number of faces has changed."""

    number: Number
    timestamp: Timestamp


class SoundDetected(Payload):
    """The number of sound sources has changed; 0 or 1 where sources cannot be told apart."""

    number: Number
    timestamp: Timestamp


class PersonLocalized(Payload):
    """Where persons are; the lists run in parallel."""

    person_ref: References
    timestamp: Timestamp
    position_data: Positions


class FaceLocalized(Payload):
    """Where faces are; the lists run in parallel."""

    face_ref: References
    timestamp: Timestamp
    position_data: Positions


class SoundLocalized(Payload):
    """Where sounds come from; the lists run in parallel."""

    sound_ref: References
    timestamp: Timestamp
    position_data: Positions


class PersonIdentified(Payload):
    """Who is there."""

    person_ref: References
    timestamp: Timestamp


class GestureRecognized(Payload):
    """A gesture was made."""

    gesture_ref: References
    timestamp: Timestamp


class SpeechInputStarted(Payload):
    """A person began to speak."""

    timestamp: Timestamp


class SpeechInputFinished(Payload):
    """A person stopped speaking."""

    timestamp: Timestamp


class SpeechRecognized(Payload):
    """What was said."""

    recognized_text: Annotated[tuple[str, ...], Data("string[]", "M", "what may have been said, the likeliest first")]
    timestamp: Timestamp


class RecognizableLanguagesResult(Payload):
    """The languages that can be recognised."""

    languages: Annotated[tuple[str, ...], Data("string[]", "M", "ISO 639-1 codes")]


_UNITLESS: Final = "the unit is ours: the standard gives none, the ontology speaks of an interval of space or of time"


class LocalizationParameters(Payload):
    """When to tell that something has moved."""

    detection_threshold: Annotated[
        int | None, Data("int", "O", "tell of movements of more than this many millimetres", note=_UNITLESS)
    ] = None
    minimum_interval: Annotated[
        int | None, Data("int", "O", "tell at most once in this many milliseconds", note=_UNITLESS)
    ] = None


class SpeechRecognitionParameters(Payload):
    """What speech to expect."""

    languages: Annotated[
        tuple[str, ...],
        Data("string[]", "M", "ISO 639-1 codes", note="the XML's default is the text jp: no array, and not ISO 639-1"),
    ] = ("ja",)
    grammar: Annotated[
        str, Data("string", "O", "the grammar to use", note="grammer in the IDL and in the text's table")
    ] = "default"
    rule: Annotated[str, Data("string", "O", "the grammar's rule to begin with")] = "default"


class GestureRecognitionParameters(Payload):
    """What gestures can be recognised."""

    recognizable_gestures: Annotated[
        tuple[str, ...] | None,
        Data("RoISIdentifier[]", "M", "the gestures it knows", note="the IDL's set_parameter lacks it", read_only=True),
    ] = None


PERSON_DETECTION: Final = ComponentType(
    code="PersonDetection",
    name="person_detecter",
    description="Tells how many persons there are.",
    source="PersonDetection.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("person_detected", "The number of persons has changed.", PersonDetected),),
    includes=(ROIS_COMMON,),
)

PERSON_LOCALIZATION: Final = ComponentType(
    code="PersonLocalization",
    name="person_localizer",
    description="Tells where persons are.",
    source="PersonLocalization.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("person_localized", "Persons have moved.", PersonLocalized),),
    parameters=LocalizationParameters,
    includes=(ROIS_COMMON,),
)

PERSON_IDENTIFICATION: Final = ComponentType(
    code="PersonIdentification",
    name="person_identifier",
    description="Tells who is there.",
    source="PersonIdentification.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("person_identified", "Persons were recognised.", PersonIdentified),),
    includes=(ROIS_COMMON,),
)

FACE_DETECTION: Final = ComponentType(
    code="FaceDetection",
    name="face_detecter",
    description="Tells how many faces there are.",
    source="FaceDetection.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("face_detected", "The number of faces has changed.", FaceDetected),),
    includes=(ROIS_COMMON,),
)

FACE_LOCALIZATION: Final = ComponentType(
    code="FaceLocalization",
    name="face_localizer",
    description="Tells where faces are.",
    source="FaceLocalization.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("face_localized", "Faces have moved.", FaceLocalized),),
    parameters=LocalizationParameters,
    includes=(ROIS_COMMON,),
)

SOUND_DETECTION: Final = ComponentType(
    code="SoundDetection",
    name="sound_detecter",
    description="Tells how many sound sources there are.",
    source="SoundDetection.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("sound_detected", "The number of sound sources has changed.", SoundDetected),),
    includes=(ROIS_COMMON,),
)

SOUND_LOCALIZATION: Final = ComponentType(
    code="SoundLocalization",
    name="sound_localizer",
    description="Tells where sounds come from.",
    source="SoundLocalization.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("sound_localized", "Sound sources have moved.", SoundLocalized),),
    parameters=LocalizationParameters,
    includes=(ROIS_COMMON,),
)

SPEECH_RECOGNITION: Final = ComponentType(
    code="SpeechRecognition",
    name="speech_recognizer",
    description="Writes down what is said.",
    source="SpeechRecognition.xml",
    function=ComponentFunction.SENSING,
    queries=(
        QueryType(
            "recognizable_languages", "Ask which languages it can be set to recognise.", RecognizableLanguagesResult
        ),
    ),
    events=(
        EventType("speech_input_started", "A person began to speak.", SpeechInputStarted),
        EventType("speech_input_finished", "A person stopped speaking.", SpeechInputFinished),
        EventType("speech_recognized", "Something was said.", SpeechRecognized),
    ),
    parameters=SpeechRecognitionParameters,
    includes=(ROIS_COMMON,),
)

GESTURE_RECOGNITION: Final = ComponentType(
    code="GestureRecognition",
    name="gesture_recognizer",
    description="Tells which gestures are made.",
    source="GestureRecognition.xml",
    function=ComponentFunction.SENSING,
    events=(EventType("gesture_recognized", "A gesture was made.", GestureRecognized),),
    parameters=GestureRecognitionParameters,
    includes=(ROIS_COMMON,),
)
