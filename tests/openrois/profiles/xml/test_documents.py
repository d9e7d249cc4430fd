"""A whole system as documents: written, read, put together again, and checked."""

import pytest

from openrois.catalog.actuation import NAVIGATION
from openrois.catalog.sensing import SPEECH_RECOGNITION
from openrois.profiles.xml.documents import Profiles, assemble, doubts, write_documents
from openrois.profiles.xml.read import ComponentDocument, EngineDocument, read_profile
from openrois.types.profiles import HRIComponentProfile, HRIEngineProfile, RoISIdentifier
from tests.support.fleet import everything
from tests.support.profiles import structural_errors

ROBOT = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=("robot/legs",))
LEGS = ComponentDocument(NAVIGATION.profile("legs"), "robot/legs")


async def test_a_robot_with_everything() -> None:
    directory = await everything().registry.discover()
    documents = write_documents(directory.profile, directory.component_profiles)
    assert len(documents) == 18
    assert {"engine.xml", "components/robot_x002F_navigation.xml"} <= documents.keys()
    assert [structural_errors(text) for text in documents.values()] == [[]] * 18
    read = assemble(read_profile(text) for text in documents.values())
    assert read == Profiles(directory.profile, directory.component_profiles)
    assert doubts(read) == []


def test_names_of_files_are_bounded_and_distinct() -> None:
    refs = tuple(f"robot/{'あ' * 120}{number}" for number in range(2))
    profile = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=refs)
    documents = write_documents(profile, dict.fromkeys(refs, NAVIGATION.profile("legs")))
    assert len(documents) == 3
    assert all(len(name) < 230 for name in documents)
    read = assemble(read_profile(text) for text in documents.values())
    assert tuple(read.components) == refs


def test_an_unwritable_profile_is_named() -> None:
    with pytest.raises(ValueError, match=r"^'robot/legs': gml:name: .* has a character that XML cannot carry"):
        write_documents(ROBOT, {"robot/legs": NAVIGATION.profile("\1")})


def test_types_are_kept_apart() -> None:
    documents = (ComponentDocument(NAVIGATION.definition()), ComponentDocument(SPEECH_RECOGNITION.definition()))
    assert assemble(documents) == Profiles(types=(NAVIGATION.definition(), SPEECH_RECOGNITION.definition()))


@pytest.mark.parametrize(
    ("documents", "sentence"),
    [
        ((EngineDocument(ROBOT), EngineDocument(ROBOT)), "there are two engines, 'robot' and 'robot'"),
        ((LEGS, LEGS), "the component 'robot/legs' has two profiles"),
        (
            (ComponentDocument(NAVIGATION.profile(), "robot/arm"), EngineDocument(ROBOT)),
            "the engine 'robot' has no component 'robot/arm'",
        ),
    ],
)
def test_what_does_not_go_together(documents: tuple[EngineDocument | ComponentDocument, ...], sentence: str) -> None:
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        assemble(documents)


class TestDoubts:
    def test_an_engine_alone_leaves_none(self) -> None:
        assert doubts(assemble([EngineDocument(ROBOT)])) == []

    @pytest.mark.parametrize(
        ("more", "sentence"),
        [
            (("robot/eye",), "the component 'robot/eye' has no profile"),
            (("robot/eye", "robot/ear"), "the component 'robot/eye' has no profile, and 1 more have none"),
        ],
    )
    def test_components_without_a_profile(self, more: tuple[str, ...], sentence: str) -> None:
        engine = ROBOT.model_copy(update={"component_ids": ("robot/legs", *more)})
        assert doubts(assemble([EngineDocument(engine), LEGS])) == [sentence]

    def test_defaults_that_do_not_fit(self) -> None:
        wrong = {"name": "level", "data_type_ref": {"code": "int"}, "default_value": "high"}
        messages = [{"name": "m", "results": [wrong]}]
        profile = HRIComponentProfile.model_validate(
            {
                "identifier": {"code": "x"},
                "name": "lamp",
                "command_profiles": [{"name": "m", "results": [wrong], "arguments": [wrong]}],
                "query_profiles": messages,
                "event_profiles": messages,
                "parameter_profiles": [wrong],
            }
        )
        sentence = "lamp: the default of 'level': 'high' is not of type int"
        assert doubts(Profiles(types=(profile,))) == [sentence] * 5
        assert doubts(Profiles(components={"robot/lamp": profile})) == [sentence] * 5

    def test_names_that_are_empty_or_stand_twice(self) -> None:
        text = {"name": "text", "data_type_ref": {"code": "string"}}
        profile = HRIComponentProfile.model_validate(
            {
                "identifier": {"code": ""},
                "name": "lamp",
                "command_profiles": [
                    {"name": "say", "arguments": [text, text, text]},
                    {"name": "say"},
                    {"name": "", "results": [{**text, "name": ""}]},
                ],
                "query_profiles": [{"name": "mood", "results": [text, text]}],
                "event_profiles": [{"name": "mood"}],
                "parameter_profiles": [text, text],
            }
        )
        assert doubts(Profiles(types=(profile,))) == [
            "lamp: its identifier is empty",
            "lamp: a command has no name",
            "lamp: the command 'say' stands twice",
            "lamp: the parameter 'text' stands twice",
            "lamp: the argument 'text' of 'say' stands twice",
            "lamp: a result of '' has no name",
            "lamp: the result 'text' of 'mood' stands twice",
        ]

    def test_engines_and_components_that_no_gateway_takes(self) -> None:
        below = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=("robot/legs", "arm/hand"))
        engine = HRIEngineProfile(
            identifier=RoISIdentifier(code="a/b"), sub_profiles=(below, below), component_ids=("robot/legs",)
        )
        assert doubts(Profiles(engine)) == [
            "'a/b' is no engine id: it has a slash",
            "the engine id 'robot' stands twice",
            "the component 'robot/legs' stands twice",
            "the component 'arm/hand' stands twice",
            "the component 'arm/hand' does not begin with the id of an engine that offers it",
        ]
