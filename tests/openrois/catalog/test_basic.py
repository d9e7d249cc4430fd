"""The seventeen basic components and RoIS_Common, against a table of the standard written down by hand.

A value is `name type obligation`, and `=default` where there is one.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import pytest

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import ComponentType
from openrois.catalog.payload import Payload
from openrois.types.values import check_value

Values = dict[str, tuple[str, ...]]


@dataclass(frozen=True)
class Row:
    name: str
    function: str | None = None
    commands: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = field(default_factory=dict)
    """Arguments and results."""
    queries: Values = field(default_factory=dict)
    events: Values = field(default_factory=dict)
    parameters: tuple[str, ...] = ()
    common: bool = True


MOMENT = "timestamp DateTime M"
DETECTED = ("number int M", MOMENT)
WHEN_TO_TELL = ("detection_threshold int O", "minimum_interval int O")
STREAM = ("stream_id String M",)


def localized(subject: str) -> tuple[str, ...]:
    return (f"{subject}_ref RoISIdentifier[] M", MOMENT, "position_data String[] M")


def streaming(name: str) -> Row:
    return Row(
        name,
        "function",
        commands={
            "connect_stream": ((), STREAM),
            "disconnect_stream": (STREAM, ()),
            "suspend_stream": (STREAM, ()),
            "resume_stream": (STREAM, ()),
        },
        queries={"get_stream_status": ("status Stream_Status M",)},
        events={"notify_stream_status": (MOMENT, "status Stream_Status M")},
        parameters=(
            "encoding_parameters String M",
            "transport_parameters String M",
            "available_encodings String M",
            "available_transports String M",
        ),
    )


TABLE = {
    "SystemInformation": Row(
        "system_info",
        queries={
            "robot_position": ("position_data String[] M", "robot_ref RoISIdentifier[] M", MOMENT),
            "engine_status": ("status Component_Status M", "operable_time DateTime O"),
        },
        common=False,
    ),
    "PersonDetection": Row("person_detecter", "sensing", events={"person_detected": DETECTED}),
    "PersonLocalization": Row(
        "person_localizer", "sensing", events={"person_localized": localized("person")}, parameters=WHEN_TO_TELL
    ),
    "PersonIdentification": Row(
        "person_identifier", "sensing", events={"person_identified": ("person_ref RoISIdentifier[] M", MOMENT)}
    ),
    "FaceDetection": Row("face_detecter", "sensing", events={"face_detected": DETECTED}),
    "FaceLocalization": Row(
        "face_localizer", "sensing", events={"face_localized": localized("face")}, parameters=WHEN_TO_TELL
    ),
    "SoundDetection": Row("sound_detecter", "sensing", events={"sound_detected": DETECTED}),
    "SoundLocalization": Row(
        "sound_localizer", "sensing", events={"sound_localized": localized("sound")}, parameters=WHEN_TO_TELL
    ),
    "SpeechRecognition": Row(
        "speech_recognizer",
        "sensing",
        queries={"recognizable_languages": ("languages string[] M",)},
        events={
            "speech_input_started": (MOMENT,),
            "speech_input_finished": (MOMENT,),
            "speech_recognized": ("recognized_text string[] M", MOMENT),
        },
        parameters=("languages string[] M =jp", "grammar string O =default", "rule string O =default"),
    ),
    "GestureRecognition": Row(
        "gesture_recognizer",
        "sensing",
        events={"gesture_recognized": ("gesture_ref RoISIdentifier[] M", MOMENT)},
        parameters=("recognizable_gestures RoISIdentifier[] M",),
    ),
    "SpeechSynthesis": Row(
        "speech_synthesizer",
        "actuation",
        queries={
            "synthesizable_languages": ("languages string[] M",),
            "available_voices": ("characters string[] M",),
        },
        parameters=(
            "speech_text string C",
            "ssml_text string C",
            "volume int O =50",
            "language string O =en",
            "character string O =default",
        ),
    ),
    "Reaction": Row(
        "reaction",
        "actuation",
        queries={"available_reactions": ("available_reactions RoISIdentifier[] M",)},
        parameters=("reaction_ref RoISIdentifier M",),
    ),
    "Navigation": Row(
        "navigation",
        "actuation",
        events={"reached_target": ("target string M", "is_final_target bool M")},
        parameters=("target_positions string[] M", "time_limit int O =0", "routing_policy string O =time"),
    ),
    "Follow": Row(
        "follower",
        "actuation",
        parameters=("target_object_ref RoISIdentifier M", "distance int M", "time_limit int O"),
    ),
    "Move": Row("move", "actuation", parameters=("line int[] C", "curve int[] C", "time int O")),
    "AudioStreaming": streaming("audio_streaming"),
    "VideoStreaming": streaming("video_streaming"),
}

OURS = {
    # The standard's default is no array and no code of ISO 639-1.
    ("SpeechRecognition", "languages string[] M =jp"): 'languages string[] M =["ja"]',
}
"""Where we say something else than the standard; a note in the catalog says why."""

ADDED = {"notify_stream_status": ("stream_id string O",)}
"""What we say beside: without it the event of a stream would not tell which."""


def written(payload: type[Payload] | None) -> tuple[str, ...]:
    """Return a payload's values as the table has them."""
    if payload is None:
        return ()
    data = payload.data()
    return tuple(
        f"{profile.name} {profile.data_type_ref.code} {data[profile.name].obligation}"
        + (f" ={profile.default_value}" if profile.default_value else "")
        for profile in payload.profiles()
    )


def kinds(types: Iterable[ComponentType] = BASIC_COMPONENTS) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("kind", types, ids=lambda kind: kind.code)


def test_they_are_seventeen_in_the_standards_order() -> None:
    assert [kind.code for kind in BASIC_COMPONENTS] == list(TABLE)


@kinds()
class TestAgainstTheTable:
    def test_names(self, kind: ComponentType) -> None:
        row = TABLE[kind.code]
        assert kind.name == row.name
        assert kind.urn == f"urn:x-rois:def:component:OMG::{kind.code}"
        assert kind.authority == "OMG"
        assert kind.source == f"{kind.code}.xml"
        assert (kind.function and kind.function.value) == row.function
        assert kind.includes == ((ROIS_COMMON,) if row.common else ())

    def test_commands(self, kind: ComponentType) -> None:
        found = {each.name: (written(each.arguments), written(each.results)) for each in kind.commands}
        assert found == TABLE[kind.code].commands
        assert list(found) == list(TABLE[kind.code].commands)
        assert all(each.timeout is None for each in kind.commands)

    def test_queries(self, kind: ComponentType) -> None:
        found = [(each.name, written(each.results)) for each in kind.queries]
        assert found == list(TABLE[kind.code].queries.items())

    def test_events(self, kind: ComponentType) -> None:
        found = [(each.name, written(each.results)) for each in kind.events]
        assert found == [(name, values + ADDED.get(name, ())) for name, values in TABLE[kind.code].events.items()]

    def test_parameters(self, kind: ComponentType) -> None:
        expected = tuple(OURS.get((kind.code, each), each) for each in TABLE[kind.code].parameters)
        assert written(kind.parameters) == expected


def test_rois_common() -> None:
    assert ROIS_COMMON.urn == "urn:x-rois:def:Component:OMG::RoISCommon"
    assert [each.name for each in ROIS_COMMON.commands] == ["start", "stop", "suspend", "resume"]
    assert {(each.arguments, each.results, each.timeout) for each in ROIS_COMMON.commands} == {(None, None, None)}
    assert [(each.name, written(each.results)) for each in ROIS_COMMON.queries] == [
        ("component_status", ("status Component_Status M",))
    ]
    assert (ROIS_COMMON.events, ROIS_COMMON.includes) == ((), ())
    assert (ROIS_COMMON.parameters, ROIS_COMMON.function) == (None, None)


@kinds((*BASIC_COMPONENTS, ROIS_COMMON))
class TestProvenance:
    def test_everything_is_described(self, kind: ComponentType) -> None:
        commands, queries, events = (
            [each.description for each in messages] for messages in (kind.commands, kind.queries, kind.events)
        )
        for text in (kind.description, *commands, *queries, *events):
            assert text.endswith("."), text
        for payload in kind.payloads():
            assert payload.__doc__
            assert all(data.description for data in payload.data().values())

    def test_what_is_not_the_standards_says_so(self, kind: ComponentType) -> None:
        for payload in kind.payloads():
            for name, data in payload.data().items():
                ours = any(f"{name} " in each for values in ADDED.values() for each in values)
                assert (data.source == "OpenRoIS") == (ours and payload.__name__ == "NotifyStreamStatus")
                assert data.source == "XML" or data.note

    def test_defaults_fit_their_types(self, kind: ComponentType) -> None:
        for payload in kind.payloads():
            for profile in payload.profiles():
                if profile.default_value:
                    check_value(profile.data_type_ref.code, profile.default_value)


@pytest.mark.parametrize(("code", "values"), OURS, ids=lambda each: each.split()[0])
def test_what_we_say_differently_has_a_note(code: str, values: str) -> None:
    kind = next(each for each in BASIC_COMPONENTS if each.code == code)
    assert kind.parameters is not None
    assert kind.parameters.data()[values.split()[0]].note
