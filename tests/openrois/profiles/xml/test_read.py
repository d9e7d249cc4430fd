"""Documents by others: what is taken, what is left out with a remark, and what is refused with line and element."""

from collections.abc import Iterable
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.catalog.actuation import NAVIGATION
from openrois.profiles.xml.parse import MAX_DEPTH, MAX_SIZE, MalformedProfile
from openrois.profiles.xml.read import ComponentDocument, EngineDocument, read_profile
from openrois.profiles.xml.write import component_xml
from openrois.types.codes import ComponentFunction

pytestmark = pytest.mark.extra(name="base")

NAMESPACES = (
    'xmlns:rois="http://www.omg.org/spec/RoIS/20240801" xmlns:gml="http://www.opengis.net/gml/3.2"'
    ' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
)
IDENTITY = '<gml:identifier codeSpace="urn:ietf:rfc:2141">urn:x-rois:def:component:Test::Lamp</gml:identifier>'
OTHER = '<gml:identifier codeSpace="urn:x-openrois:id">robot</gml:identifier>'
VALUE = 'rois:name="level"><rois:data_type_ref rois:code="int"/>'


def component(*lines: str, attributes: str = 'gml:id="component_profile"', identity: str = IDENTITY) -> str:
    """Return a document whose `lines` begin at line 3."""
    body = "\n".join(lines)
    return f"<rois:HRIComponentProfile {NAMESPACES} {attributes}>\n{identity}\n{body}\n</rois:HRIComponentProfile>"


def engine(*lines: str, attributes: str = 'gml:id="e"', identity: str = IDENTITY) -> str:
    body = "\n".join(lines)
    return f"<rois:HRIEngineProfile {NAMESPACES} {attributes}>\n{identity}\n{body}\n</rois:HRIEngineProfile>"


def message(kind: str, content: str = "", attributes: str = 'rois:name="glow"') -> str:
    return f'<rois:MessageProfile xsi:type="rois:{kind}MessageProfileType" {attributes}>{content}</rois:MessageProfile>'


def read_component(document: str | bytes) -> ComponentDocument:
    read = read_profile(document)
    assert isinstance(read, ComponentDocument)
    return read


class TestWhatOthersWrite:
    def test_white_space_around_a_namespace(self) -> None:
        document = component(message("Event")).replace("20240801", "20240801 ")
        assert read_component(document).profile.has_event("glow")

    def test_the_component_with_a_capital(self) -> None:
        urn = "urn:x-rois:def:Component:OMG::RoISCommon"
        document = component(
            "<gml:name>rois_common</gml:name>",
            f"<rois:SubComponentProfile>{urn}</rois:SubComponentProfile>",
            identity=IDENTITY.replace("urn:x-rois:def:component:Test::Lamp", urn),
        )
        profile = read_component(document).profile
        assert (profile.identifier.code, profile.identifier.authority) == (urn, "OMG")
        assert profile.sub_component_profiles == (urn,)

    @pytest.mark.parametrize("kind", ["Query", "Event"])
    def test_arguments_of_queries_and_events(self, kind: str) -> None:
        value = f"<rois:Results {VALUE}</rois:Results>"
        arguments = value.replace("Results", "Arguments")
        read = read_component(component("<gml:name>lamp</gml:name>", message(kind, value + arguments)))
        found = [
            *(each.results for each in read.profile.query_profiles),
            *(each.results for each in read.profile.event_profiles),
        ]
        assert [[each.name for each in results] for results in found] == [["level"]]
        assert read.remarks == ("line 4: the arguments of 'glow' are left out: only commands take some",)

    def test_other_prefixes(self) -> None:
        document = component(message("Command")).replace("xmlns:rois", "xmlns:r").replace("rois:", "r:")
        document = document.replace("x-r:", "x-rois:").replace("xmlns:gml", "xmlns:g").replace("gml:", "g:")
        assert read_component(document).profile.command("glow") is not None

    def test_a_default_namespace(self) -> None:
        document = component(message("Command")).replace("xmlns:rois=", 'xmlns:rois="x" xmlns=')
        document = document.replace("<rois:", "<").replace("</rois:", "</").replace('"rois:Command', '"Command')
        with pytest.raises(MalformedProfile, match=r"line 3: rois:MessageProfile has the attribute \{x\}name"):
            read_component(document)

    def test_prefixes_that_are_declared_where_they_are_needed(self) -> None:
        inner = message("Query").replace(
            "<rois:MessageProfile", '<rois:MessageProfile xmlns:rois="http://www.omg.org/spec/RoIS/20240801"'
        )
        again = message("Query", attributes='rois:name="again"')
        profile = read_component(component(inner, again)).profile
        assert [each.name for each in profile.query_profiles] == ["glow", "again"]

    def test_text_over_several_lines(self) -> None:
        identity = '<gml:identifier codeSpace="http://example.org/codes">\n  lamp\n  </gml:identifier>'
        profile = read_component(component("<gml:name> the\n lamp </gml:name>", identity=identity)).profile
        assert (profile.identifier.code, profile.identifier.authority) == ("lamp", "")
        assert profile.identifier.codebook_ref == "http://example.org/codes"
        assert profile.name == " the\n lamp "

    def test_what_gml_allows_beside(self) -> None:
        identity = (
            "<!-- a comment --><?a hint?><gml:metaDataProperty><anything><goes/></anything></gml:metaDataProperty>"
            f"<gml:description>A lamp.</gml:description><gml:descriptionReference/>{IDENTITY}"
            '<gml:name codeSpace="http://example.org/">one</gml:name><gml:name>two</gml:name><gml:remarks>!</gml:remarks>'
        )
        attributes = 'gml:id="a" xsi:schemaLocation="a b" xml:lang="en"'
        read = read_component(component(attributes=attributes, identity=identity))
        assert (read.profile.name, read.component_ref) == ("one", "a")
        assert read.remarks == ("line 2: the name 'two' is left out: there is another",)

    def test_a_component_without_a_name(self) -> None:
        assert read_component(component()).profile.name == ""

    def test_cdata_and_character_references(self) -> None:
        document = component("<gml:name><![CDATA[<a>]]>&amp;&#x62;</gml:name>")
        assert read_component(document).profile.name == "<a>&b"

    @pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1"])
    def test_encodings(self, encoding: str) -> None:
        text = f'<?xml version="1.0" encoding="{encoding}"?>\n' + component("<gml:name>é</gml:name>")
        assert read_component(text.encode(encoding)).profile.name == "é"
        assert read_component(text).profile.name == "é"

    def test_a_timeout_with_white_space(self) -> None:
        document = component(message("Command", attributes='rois:name="glow" rois:timeout=" +500 "'))
        command = read_component(document).profile.command("glow")
        assert command is not None
        assert command.timeout == 500

    def test_a_code_space_with_white_space(self) -> None:
        identity = IDENTITY.replace("urn:ietf:rfc:2141", " my book&#10;")
        profile = read_component(component(identity=identity)).profile
        assert profile.identifier.codebook_ref == "my book"
        assert read_component(component_xml(profile)).profile == profile

    def test_an_engine_of_others(self) -> None:
        read = read_profile(
            engine(
                "<gml:name>Main HRI</gml:name>",
                '<rois:SubProfile gml:id="s">',
                f"{OTHER}<rois:HRIComponent> c1 </rois:HRIComponent></rois:SubProfile>",
                "<rois:HRIComponent>c2</rois:HRIComponent><rois:HRIComponent>none.x</rois:HRIComponent>",
                f"<rois:ParameterProfile {VALUE}</rois:ParameterProfile>",
            )
        )
        assert isinstance(read, EngineDocument)
        assert read.profile.component_refs() == ("c2", "c1")
        assert read.profile.parameter_profiles[0].name == "level"
        assert read.remarks == ()

    def test_an_engine_without_components(self) -> None:
        read = read_profile(engine(f'<rois:SubProfile gml:id="s">{OTHER}</rois:SubProfile>'))
        assert isinstance(read, EngineDocument)
        assert read.profile.component_refs() == ()
        assert read.remarks == (
            "line 1: rois:HRIEngineProfile has no rois:HRIComponent: the schema wants one",
            "line 3: rois:SubProfile has no rois:HRIComponent: the schema wants one",
        )


def malformed() -> Iterable[tuple[str, str]]:
    """Yield sentences with documents."""
    result = f"<rois:Results {VALUE}</rois:Results>"
    parameter = f"<rois:ParameterProfile {VALUE}</rois:ParameterProfile>"
    name = "<gml:name codeSpace='urn:x-openrois:profile:{}'>{}</gml:name>"
    yield "line 1: rois:HRIComponentProfile has no gml:id", component(attributes="")
    yield "line 1: rois:HRIComponentProfile has 'a/b' where an XML id is expected", component(attributes='gml:id="a/b"')
    yield "line 1: rois:HRIComponentProfile has no gml:identifier", component(identity="")
    yield "line 2: gml:identifier stands a second time in rois:HRIComponentProfile", component(identity=IDENTITY * 2)
    yield (
        "line 2: gml:identifier has no codeSpace",
        component(identity="<gml:identifier>x</gml:identifier>"),
    )
    yield (
        "line 1: rois:HRIComponentProfile has the attribute rois:name",
        component(attributes='gml:id="a" rois:name="x"'),
    )
    yield "line 1: rois:HRIComponentProfile has the attribute name, and", component(attributes='gml:id="a" name="x"')
    yield "line 1: rois:HRIComponentProfile holds the text 'hello'", component("hello")
    yield (
        "line 4: gml:name cannot stand here in rois:HRIComponentProfile; what can is rois:MessageProfile, rois:Para",
        component(message("Query"), "<gml:name>late</gml:name>"),
    )
    yield "line 3: rois:Arm cannot stand here in rois:HRIComponentProfile", component("<rois:Arm/>")
    yield "line 3: {urn:x}Arm cannot stand here", component("<Arm xmlns='urn:x'/>")
    yield "line 3: Arm cannot stand here", component("<Arm/>")
    yield (
        "line 4: rois:MessageProfile cannot stand here in rois:HRIComponentProfile; what can is rois:ParameterProfile",
        component(parameter, message("Query")),
    )
    yield "line 3: rois:MessageProfile has no rois:name", component(message("Query", attributes=""))
    yield "line 3: rois:MessageProfile has no rois:name", component(message("Command", attributes=""))
    yield (
        "line 3: rois:MessageProfile has the attribute rois:timeout, and can have rois:name",
        component(message("Query", attributes='rois:name="x" rois:timeout="5"')),
    )
    for kind in ("Verbal", ""):
        yield "line 3: rois:MessageProfile does not say by its xsi:type whether", component(message(kind))
    for attribute in ("", 'xsi:type="x:CommandMessageProfileType"', 'xsi:type="CommandMessageProfileType"'):
        yield (
            "line 3: rois:MessageProfile does not say by its xsi:type whether",
            component(f'<rois:MessageProfile {attribute} rois:name="x"/>'),
        )
    for timeout in ("soon", "1.5", "", "9" * 21, "٣"):
        yield (
            "line 3: rois:MessageProfile has the timeout",
            component(message("Command", attributes=f'rois:name="x" rois:timeout="{timeout}"')),
        )
    yield (
        "line 3: rois:Results cannot stand here in rois:MessageProfile; what can is rois:Arguments",
        component(message("Command", result.replace("Results", "Arguments") + result)),
    )
    yield "line 3: rois:Results has no rois:data_type_ref", component(message("Query", '<rois:Results rois:name="x"/>'))
    yield "line 3: rois:data_type_ref has no rois:code", component(parameter.replace('rois:code="int"', ""))
    yield (
        "line 3: rois:data_type_ref has the attribute rois:unit",
        component(parameter.replace("rois:code", "rois:unit")),
    )
    yield (
        "line 3: a cannot stand here in rois:data_type_ref; what can is nothing",
        component(parameter.replace('"int"/>', '"int"><a/></rois:data_type_ref>')),
    )
    yield (
        "line 3: b cannot stand in rois:SubComponentProfile, which holds text",
        component("<rois:SubComponentProfile>a<b/></rois:SubComponentProfile>"),
    )
    yield (
        "line 3: gml:name says 'dancing', which is no function: actuation, sensing",
        component(name.format("function", "dancing")),
    )
    yield "line 4: gml:name says the function a second time", component(*[name.format("function", "sensing")] * 2)
    yield "line 3: gml:name is said to be 'mood', which is none of function", component(name.format("mood", "good"))
    yield (
        "line 1: rois:HRIEngineProfile is an engine, which has no function",
        engine(name.format("function", "sensing")),
    )
    one = "<rois:HRIComponent>c</rois:HRIComponent>"
    yield "line 4: rois:HRIComponent has the XML id 'c', which stands twice", engine(one, one)
    yield "line 3: rois:HRIComponent has the XML id 'e', which stands twice", engine(one.replace(">c<", ">e<"))
    yield (
        "line 3: rois:HRIComponent has 'robot/arm' where an XML id is expected",
        engine(one.replace("c<", "robot/arm<")),
    )
    yield "line 3: rois:HRIComponent has '' where an XML id is expected", engine("<rois:HRIComponent/>")
    yield (
        "line 4: rois:HRIComponent has the component 'c', which stands twice",
        engine(one, one.replace(">c", ">_x0063_")),
    )
    below = '<rois:SubProfile gml:id="s">{}</rois:SubProfile>'
    yield "line 3: rois:SubProfile has the engine id 'Lamp'", engine(below.format(IDENTITY))
    nameless = '<gml:identifier codeSpace="a:b"/>'
    yield "line 3: rois:SubProfile has an empty engine id", engine(below.format(nameless))
    yield "line 3: rois:SubProfile has no gml:id", engine(f"<rois:SubProfile>{IDENTITY}{one}</rois:SubProfile>")
    yield "line 1: rois:Parameter is no profile", f"<rois:Parameter {NAMESPACES}/>"
    yield "line 1: html is no profile", "<html/>"
    yield (
        "line 1: {http://www.omg.org/spec/RoIS/20991231}HRIComponentProfile is no profile",
        component().replace("20240801", "20991231"),
    )
    yield "line 1: this is no XML: no element found", ""
    yield "line 1: this is no XML: not well-formed (invalid token)", '{"profile": null}'
    yield "line 4: this is no XML: mismatched tag", component("<gml:name>", "</rois:name>").replace("\n\n", "\n") + "\n"
    yield "line 1: this is no XML: unbound prefix", "<rois:HRIComponentProfile/>"
    yield "line 1: this is no XML: not well-formed", "<a>\ud800</a>"
    yield "line 3: this is no XML: undefined entity", component("<gml:name>&eacute;</gml:name>")
    yield "line 1: a profile has no document type", '<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>'
    yield "line 2: a profile has no document type", '<?xml version="1.0"?>\n<!DOCTYPE a SYSTEM "file:///etc/hosts"><a/>'
    yield f"line 1: elements may be nested {MAX_DEPTH} deep at most", "<a>" * (MAX_DEPTH + 1)
    yield f"line 1: the document has more than {MAX_SIZE} bytes", " " * (MAX_SIZE + 1)


CASES = list(malformed())


@pytest.mark.parametrize(("sentence", "document"), CASES, ids=range(len(CASES)))
def test_what_is_refused(sentence: str, document: str) -> None:
    with pytest.raises(MalformedProfile) as raised:
        read_profile(document)
    assert str(raised.value).startswith(sentence)
    assert len(str(raised.value)) < 500
    assert str(raised.value).startswith(f"line {raised.value.line}: ")


@pytest.mark.parametrize("encoding", ["martian", "shift_jis", "idna"])
def test_encodings_that_are_not_read(encoding: str) -> None:
    with pytest.raises(MalformedProfile, match="line 1: "):
        read_profile(f'<?xml version="1.0" encoding="{encoding}"?><a/>'.encode())


def test_what_is_deep_but_not_too_deep() -> None:
    with pytest.raises(MalformedProfile, match="is no profile"):
        read_profile("<a>" * MAX_DEPTH + "</a>" * MAX_DEPTH)


def test_the_function_of_ours_is_read() -> None:
    read = read_component(component_xml(NAVIGATION.definition()))
    assert read.profile.function is ComponentFunction.ACTUATION


VALID = component_xml(NAVIGATION.profile(), "robot/navigation")


@settings(max_examples=150, deadline=None)
@given(
    st.integers(0, len(VALID)), st.integers(0, 40), st.text(max_size=8) | st.sampled_from(["<", "]]>", "<a>", "&b;"])
)
def test_a_damaged_document_is_read_or_refused(at: int, length: int, instead: str) -> None:
    with suppress(MalformedProfile):
        read_profile(VALID[:at] + instead + VALID[at + length :])


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=60) | st.text(max_size=60))
def test_anything_is_read_or_refused(document: str | bytes) -> None:
    with pytest.raises(MalformedProfile):
        read_profile(document)
