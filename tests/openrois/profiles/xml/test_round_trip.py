"""What is written as XML has the schema's structure and reads back as it was."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import ComponentType
from openrois.profiles.xml.names import engine_id_text, no_component, read_id, stands_for_no_component, write_id
from openrois.profiles.xml.parse import MAX_DEPTH, MAX_SIZE
from openrois.profiles.xml.read import ComponentDocument, EngineDocument, read_profile
from openrois.profiles.xml.write import component_xml, engine_xml
from openrois.types.profiles import (
    CommandMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    RoISIdentifier,
)
from tests.support.profiles import components, engines, references, structural_errors

KINDS = (*BASIC_COMPONENTS, ROIS_COMMON)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.code)
def test_the_catalog(kind: ComponentType) -> None:
    for profile, ref in ((kind.definition(), ""), (kind.profile("part"), "robot/part")):
        text = component_xml(profile, ref)
        assert structural_errors(text) == []
        assert read_profile(text) == ComponentDocument(profile, ref)


def test_a_type_looks_as_in_the_standards_files() -> None:
    text = component_xml(BASIC_COMPONENTS[13].definition())
    assert text == (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<rois:HRIComponentProfile xmlns:rois="http://www.omg.org/spec/RoIS/20240801"'
        ' xmlns:gml="http://www.opengis.net/gml/3.2" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
        ' gml:id="component_profile">\n'
        '  <gml:identifier codeSpace="urn:ietf:rfc:2141">urn:x-rois:def:component:OMG::Follow</gml:identifier>\n'
        "  <gml:name>follower</gml:name>\n"
        '  <gml:name codeSpace="urn:x-openrois:profile:function">actuation</gml:name>\n'
        '  <gml:name codeSpace="urn:x-openrois:profile:part">legs</gml:name>\n'
        "  <rois:SubComponentProfile>urn:x-rois:def:Component:OMG::RoISCommon</rois:SubComponentProfile>\n"
        '  <rois:ParameterProfile rois:name="target_object_ref" rois:description="whom or what to follow">\n'
        '    <rois:data_type_ref rois:code="RoISIdentifier"/>\n'
        "  </rois:ParameterProfile>\n"
        '  <rois:ParameterProfile rois:name="distance" rois:description="the millimetres to stay behind">\n'
        '    <rois:data_type_ref rois:code="int"/>\n'
        "  </rois:ParameterProfile>\n"
        '  <rois:ParameterProfile rois:name="time_limit" rois:description="the milliseconds to follow for at most">\n'
        '    <rois:data_type_ref rois:code="int"/>\n'
        "  </rois:ParameterProfile>\n"
        "</rois:HRIComponentProfile>\n"
    )


def test_results_come_before_arguments() -> None:
    value = ParameterProfile(name="level", data_type_ref=RoISIdentifier(code="int"))
    command = CommandMessageProfile(name="glow", results=(value,), arguments=(value,), timeout=500)
    lamp = HRIComponentProfile(
        identifier=RoISIdentifier(code="urn:x-rois:def:component:Example::Lamp", authority="Example", version="2"),
        name="lamp",
        sub_component_profiles=(ROIS_COMMON.urn, "urn:x-rois:def:component:Example::Light"),
        command_profiles=(command,),
    )
    text = component_xml(lamp, "house/lamp")
    assert 'gml:id="house_x002F_lamp"' in text
    assert 'rois:name="glow" rois:timeout="500"' in text
    assert text.index("rois:Results") < text.index("rois:Arguments")
    assert structural_errors(text) == []
    assert read_profile(text) == ComponentDocument(lamp, "house/lamp")


def test_an_engine() -> None:
    robot = HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=("robot/arm", "robot/a b"))
    gateway = HRIEngineProfile(identifier=RoISIdentifier(code="gateway"), sub_profiles=(robot,))
    text = engine_xml(gateway)
    assert structural_errors(text) == []
    assert read_profile(text) == EngineDocument(gateway)
    assert text.splitlines()[2:] == [
        '  <gml:identifier codeSpace="urn:x-openrois:id">gateway</gml:identifier>',
        "  <gml:name>gateway</gml:name>",
        '  <rois:SubProfile gml:id="engine.robot">',
        '    <gml:identifier codeSpace="urn:x-openrois:id">robot</gml:identifier>',
        "    <gml:name>robot</gml:name>",
        "    <rois:HRIComponent>robot_x002F_arm</rois:HRIComponent>",
        "    <rois:HRIComponent>robot_x002F_a_x0020_b</rois:HRIComponent>",
        "  </rois:SubProfile>",
        # The schema wants one component at least, and the gateway has none of its own.
        "  <rois:HRIComponent>none.gateway</rois:HRIComponent>",
        "</rois:HRIEngineProfile>",
    ]


@settings(max_examples=60, deadline=None)
@given(components, references | st.just(""))
def test_any_component(profile: HRIComponentProfile, component_ref: str) -> None:
    text = component_xml(profile, component_ref)
    assert structural_errors(text) == []
    for document in (text, text.encode()):
        assert read_profile(document) == ComponentDocument(profile, component_ref)
    assert HRIComponentProfile.model_validate_json(profile.model_dump_json()) == profile


@settings(max_examples=40, deadline=None)
@given(engines())
def test_any_engine(profile: HRIEngineProfile) -> None:
    text = engine_xml(profile)
    assert structural_errors(text) == []
    assert read_profile(text) == EngineDocument(profile)


class TestIds:
    @settings(deadline=None)
    @given(st.text(min_size=1))
    def test_any_reference_is_read_back(self, reference: str) -> None:
        xml_id = write_id(reference)
        assert xml_id.isascii()
        assert not xml_id[0].isdigit()
        assert read_id(xml_id) == reference
        assert not stands_for_no_component(xml_id)
        assert xml_id != "component_profile"
        assert not xml_id.startswith("engine.")

    @pytest.mark.parametrize(
        ("reference", "xml_id"),
        [
            ("robot/arm", "robot_x002F_arm"),
            ("plain-1.b_c", "plain-1.b_c"),
            ("1", "_x0031_"),
            ("_x002F_", "_x005F_x002F_"),
            ("\U0001f600/é", "_x01F600__x002F__x00E9_"),
            ("engine.x", "_x0065_ngine.x"),
            ("none.x", "_x006E_one.x"),
            ("component_profile", "_x0063_omponent_profile"),
            ("component_profiles", "component_profiles"),
            ("\ud800", "_xD800_"),
        ],
    )
    def test_how_they_look(self, reference: str, xml_id: str) -> None:
        assert write_id(reference) == xml_id
        assert read_id(xml_id) == reference

    def test_what_is_no_character_stands_for_itself(self) -> None:
        assert read_id("a_xFFFFFF_b_x00g0_") == "a_xFFFFFF_b_x00g0_"

    def test_those_of_engines_are_their_own(self) -> None:
        assert engine_id_text("a b") == "engine.a_x0020_b"
        assert no_component("a b") == "none.a_x0020_b"


class TestWhatXmlCannotCarry:
    def component(self, **changes: object) -> HRIComponentProfile:
        return HRIComponentProfile.model_validate({"identifier": {"code": "x"}, "name": "x", **changes})

    @pytest.mark.parametrize("character", ["\0", "\x1b", "\ud800", "\ufffe"])
    def test_characters(self, character: str) -> None:
        for changes in (
            {"name": character},
            {"sub_component_profiles": [character]},
            {"query_profiles": [{"name": character}]},
        ):
            with pytest.raises(ValueError, match=rf"has a character that XML cannot carry: U\+{ord(character):04X}"):
                component_xml(self.component(**changes))

    @pytest.mark.parametrize("name", ["\nlamp", "lamp \n", " \n"])
    def test_line_breaks_at_the_ends_of_a_text(self, name: str) -> None:
        with pytest.raises(ValueError, match=r"gml:name: .* begins or ends with a line break"):
            component_xml(self.component(name=name))

    def test_more_than_is_read(self) -> None:
        engine = HRIEngineProfile(identifier=RoISIdentifier(code="0"))
        for number in range(1, MAX_DEPTH - 1):
            engine = HRIEngineProfile(identifier=RoISIdentifier(code=str(number)), sub_profiles=(engine,))
        assert read_profile(engine_xml(engine)) == EngineDocument(engine)
        with pytest.raises(ValueError, match=f"^elements may be nested {MAX_DEPTH} deep at most$"):
            engine_xml(HRIEngineProfile(identifier=RoISIdentifier(code="robot"), sub_profiles=(engine,)))
        with pytest.raises(ValueError, match=f"^the document would have more than {MAX_SIZE} bytes$"):
            component_xml(self.component(name="あ" * (MAX_SIZE // 3)))

    def test_endless_timeouts(self) -> None:
        profile = self.component(command_profiles=[{"name": "start", "timeout": 10**20}])
        with pytest.raises(ValueError, match="the timeout of the command 'start' has more than 20 digits"):
            component_xml(profile)

    @pytest.mark.parametrize(
        ("codes", "refs", "sentence"),
        [
            (("a", "b", "a"), (), "the engine id 'a' stands twice, which an XML id cannot"),
            (("a", "", "c"), (), "the engine id is empty, which an XML id cannot be"),
            (("a", "b", "c"), ("a/x", "a/x"), "the component 'a/x' stands twice, which an XML id cannot"),
            (("a", "b", "c"), ("",), "the component is empty, which an XML id cannot be"),
        ],
    )
    def test_ids(self, codes: tuple[str, ...], refs: tuple[str, ...], sentence: str) -> None:
        first, *rest = (RoISIdentifier(code=code) for code in codes)
        below = tuple(HRIEngineProfile(identifier=each) for each in rest)
        with pytest.raises(ValueError, match=sentence):
            engine_xml(HRIEngineProfile(identifier=first, sub_profiles=below, component_ids=refs))
