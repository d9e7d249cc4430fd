"""The catalog and our documents against the standard's own files, if OPENROIS_NORMATIVE_DIR says where they are."""

import os
from pathlib import Path

import pytest
from lxml import etree

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.profiles.xml.write import component_xml, engine_xml
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from tests.support.normative import differences, schema

KINDS = (*BASIC_COMPONENTS, ROIS_COMMON)
GATEWAY = HRIEngineProfile(
    identifier=RoISIdentifier(code="gateway"),
    sub_profiles=(HRIEngineProfile(identifier=RoISIdentifier(code="robot"), component_ids=("robot/arm",)),),
)


@pytest.fixture
def normative() -> Path:
    """The directory with the standard's files."""
    given = os.environ.get("OPENROIS_NORMATIVE_DIR")
    if not given:
        pytest.skip("OPENROIS_NORMATIVE_DIR is not set: it names a directory with the standard's XML files")
    return Path(given)


def test_the_catalog_says_what_the_standards_files_say(normative: Path) -> None:
    assert differences(normative) == []


def test_our_documents_are_valid_in_the_standards_schema(normative: Path) -> None:
    loaded = schema(normative)
    if loaded is None:
        pytest.skip("XML-Profiles.xsd and the GML schema that it imports are not in OPENROIS_NORMATIVE_DIR")
    for text in documents():
        assert loaded.validate(etree.fromstring(text.encode())), loaded.error_log


def documents() -> list[str]:
    components = [text for kind in KINDS for text in (component_xml(kind.definition()), component_xml(kind.profile()))]
    return [engine_xml(GATEWAY), *components]


class TestTheCheckItself:
    """Files of the same shape, made here."""

    @pytest.fixture
    def files(self, tmp_path: Path) -> Path:
        """The catalog as files, with what is known of the standard's own."""
        folder = tmp_path / "xml"
        folder.mkdir()
        for kind in KINDS:
            text = component_xml(kind.definition())
            text = text.replace("[&quot;ja&quot;]", "jp").replace("20240801", "20240801 ")
            if kind.code.endswith("Streaming"):
                event = text.index('rois:name="notify_stream_status"')
                at = text.index("<rois:Results", text.index('rois:name="status"', event))
                text = text[:at] + text[at:].replace("rois:Results", "rois:Arguments", 2)
            (folder / f"{kind.code}.xml").write_text(text)
        return tmp_path

    def test_what_is_known_is_no_difference(self, files: Path) -> None:
        assert differences(files) == []

    @pytest.mark.parametrize(
        ("code", "ours", "theirs", "place"),
        [
            ("Navigation", "OMG::Navigation", "OMG::Driving", "Navigation: identifier: 'Navigation' here, 'Driving"),
            ("Navigation", ">navigation<", ">navigator<", "Navigation: name: 'navigation' here, 'navigator' there"),
            ("Navigation", "OMG::RoISCommon", "OMG::Common", "Navigation: includes: 'urn"),
            ("Navigation", '"reached_target"', '"reached"', "Navigation: event reached_target: 'there' here, 'nothing"),
            (
                "Navigation",
                'default_value="0"',
                'default_value="1"',
                "Navigation: parameter time_limit: default: '0' h",
            ),
            ("Navigation", 'rois:code="bool"', 'rois:code="int"', "Navigation: event reached_target: result is_final"),
            ("Navigation", '"routing_policy"', '"policy"', "Navigation: parameter routing_policy: type: 'string' here"),
            ("Navigation", '"EventMessage', '"QueryMessage', "Navigation: event reached_target: 'there' here"),
            ("VideoStreaming", '"connect_stream"', '"connect"', "VideoStreaming: command connect_stream: 'there' here"),
            ("VideoStreaming", "_stream_status", "_status", "VideoStreaming: query get_stream_status: 'there' here"),
            ("RoISCommon", "def:Component", "def:component", "RoISCommon: identifier: 'urn:x-rois:def:Component:OMG"),
        ],
    )
    def test_a_difference_is_found(self, code: str, ours: str, theirs: str, place: str, files: Path) -> None:
        file = files / "xml" / f"{code}.xml"
        text = file.read_text()
        ours, theirs = ours.replace('"E', '"rois:E'), theirs.replace('"Q', '"rois:Q')
        assert ours in text
        file.write_text(text.replace(ours, theirs))
        found = differences(files)
        assert found
        assert any(each.startswith(place) for each in found), found

    def test_a_missing_file_is_found(self, files: Path) -> None:
        (files / "xml" / "Move.xml").unlink()
        assert differences(files) == ["Move: there is no Move.xml"]

    def test_a_schema_is_used_where_gml_is_beside_it(self, tmp_path: Path) -> None:
        assert schema(tmp_path) is None
        (tmp_path / "XML-Profiles.xsd").write_text(SCHEMA)
        assert schema(tmp_path) is None
        (tmp_path / "gml.xsd").write_text(GML)
        loaded = schema(tmp_path)
        assert loaded is not None
        valid = component_xml(BASIC_COMPONENTS[0].definition())
        assert loaded.validate(etree.fromstring(valid.encode()))
        assert not loaded.validate(etree.fromstring(valid.replace("gml:identifier", "gml:id").encode()))


SCHEMA = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:gml="http://www.opengis.net/gml/3.2"
    targetNamespace="http://www.omg.org/spec/RoIS/20240801" elementFormDefault="qualified">
  <xs:import namespace="http://www.opengis.net/gml/3.2" schemaLocation="gml.xsd"/>
  <xs:element name="HRIComponentProfile">
    <xs:complexType>
      <xs:sequence>
        <xs:element ref="gml:identifier"/>
        <xs:any minOccurs="0" maxOccurs="unbounded" processContents="skip"/>
      </xs:sequence>
      <xs:anyAttribute processContents="skip"/>
    </xs:complexType>
  </xs:element>
</xs:schema>"""
GML = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema" targetNamespace="http://www.opengis.net/gml/3.2">
  <xs:element name="identifier"/>
</xs:schema>"""
