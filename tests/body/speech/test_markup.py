from contextlib import suppress
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.speech.markup import MAX_DEPTH, MAX_TEXT, MarkupError, plain_text, safe_ssml


def test_text_stays_as_it_is_but_for_control_characters() -> None:
    assert plain_text("Grüß dich,\n世界 🙂 <b> [[x]]\t").spoken == "Grüß dich,\n世界 🙂 <b> [[x]]\t"
    assert plain_text("a\x01+10p\x00b\x9f\ud800c\r").spoken == "a +10p b  c "
    assert list(plain_text("ab").origins) == [(0, 1), (1, 2)]


def test_a_text_that_is_too_long_is_refused() -> None:
    assert plain_text("x" * MAX_TEXT)
    with pytest.raises(MarkupError, match="at most 4000 are allowed"):
        plain_text("x" * (MAX_TEXT + 1))
    with pytest.raises(MarkupError, match="at most 4000 are allowed"):
        safe_ssml("x" * (MAX_TEXT + 1))


@pytest.mark.parametrize(
    ("document", "expected"),
    [
        ("Hello", "<speak>Hello</speak>"),
        ("<speak>a</speak>", "<speak>a</speak>"),
        ('<?xml version="1.0"?><speak xml:lang="de">a</speak>', '<speak xml:lang="de">a</speak>'),
        ("  <p>a &amp; b</p><s>c &lt; d</s>", "<speak><p>a &amp; b</p><s>c &lt; d</s></speak>"),
        ('a<break time="1s"/>b', '<speak>a<break time="1s"></break>b</speak>'),
        (
            '<prosody rate="+10%" pitch="high">a</prosody>',
            '<speak><prosody rate="+10%" pitch="high">a</prosody></speak>',
        ),
        ('<sub alias="Robots &amp; Sons">Ro<b>IS</b></sub> a', "<speak>Robots &amp; Sons a</speak>"),
        ("<sub>RoIS</sub>", "<speak>RoIS</speak>"),
        ('a<mark name="x &lt;"/>b<mark/><mark name="y"/>', '<speak>a<mark name="0"/>b<mark name="1"/></speak>'),
        ('<audio src="/etc/passwd">a</audio>', "<speak>a</speak>"),
        ('<voice name="../../x" gender="female">a</voice>', '<speak><voice gender="female">a</voice></speak>'),
        ("<break time='1s\"/&gt;'/>", "<speak><break></break></speak>"),
        ('<emphasis level="' + "x" * 101 + '">a</emphasis>', "<speak><emphasis>a</emphasis></speak>"),
        ("a<!-- b --><?c d?>", "<speak>a</speak>"),
        ("<![CDATA[<audio src='x'/>]]>", "<speak>&lt;audio src='x'/&gt;</speak>"),
    ],
)
def test_only_harmless_elements_stay(document: str, expected: str) -> None:
    assert safe_ssml(document).spoken == expected


def origins(document: str, spoken: str) -> str:
    """What of the document these words of the script stand for."""
    script = safe_ssml(document)
    first = script.spoken.index(spoken)
    return document[script.origins[first][0] : script.origins[first + len(spoken) - 1][1]]


@pytest.mark.parametrize(
    ("document", "spoken", "stands_for"),
    [
        ("one two", "two", "two"),
        ("  <speak>one two</speak>", "two", "two"),
        ("\t<p>größer 🙂 two</p>", "two", "two"),
        ("\t<p>größer 🙂 two</p>", "größer", "größer"),
        ("Tom &amp; Jerry", "&amp;", "&amp;"),
        ("Tom &amp; Jerry", "Jerry", "Jerry"),
        ("&#x41;BC", "ABC", "&#x41;BC"),
        ("<![CDATA[a &amp; < b]]> c", "&lt;", "<"),
        ("<![CDATA[a &amp; < b]]> c", "b", "b"),
        ("a <audio src='x'>sound</audio> b", "sound", "sound"),
        ("<sub alias='World Web'>W<i>W</i>W</sub> b", "World Web", "W<i>W</i>W"),
        ("<sub alias='World Web'/> b", "World", ""),
        ("<sub alias='World Web'>WW</sub> c", "c", "c"),
    ],
)
def test_each_character_stands_for_one_of_the_document(document: str, spoken: str, stands_for: str) -> None:
    assert origins(document, spoken) == stands_for


def test_marks_keep_their_names() -> None:
    assert safe_ssml('<mark name="x &lt;"/><mark name="' + "y" * 200 + '"/>').marks == ("x <", "y" * 100)


@pytest.mark.parametrize(
    ("document", "named"),
    [
        ("<speak>", "not well-formed"),
        ("a < b", "not well-formed"),
        ("&unknown;", "not well-formed"),
        ("&#1;", "not well-formed"),
        ("<a:b>x</a:b><speak/></speak>", "not well-formed"),
        ('<?xml version="1.0"?><!DOCTYPE speak [<!ENTITY a "b">]><speak>&a;</speak>', "declares a document type"),
        ("<p>" * MAX_DEPTH + "</p>" * MAX_DEPTH, "nested more than 8 deep"),
    ],
)
def test_harmful_document_is_refused(document: str, named: str) -> None:
    with pytest.raises(MarkupError, match=named):
        safe_ssml(document)


pieces = st.sampled_from(
    [
        "<speak>",
        "</speak>",
        "<p>",
        "</p>",
        "<audio src='x'>",
        "</audio>",
        "<break time='",
        "<sub alias='x y'>",
        "</sub>",
        "<![CDATA[",
        "<mark name='",
        "'/>",
        "&amp;",
        "&#x41;",
        "]]>",
    ]
)


@given(st.lists(pieces | st.text(max_size=5), max_size=12).map("".join))
@settings(max_examples=200, deadline=None)
def test_output_is_well_formed_and_has_known_elements(document: str) -> None:
    with suppress(MarkupError):
        script = safe_ssml(document)
        assert len(script.origins) == len(script.spoken)
        assert len(script.source) == len(document)
        assert all(0 <= first <= last <= len(document) for first, last in script.origins)
        tree = ET.fromstring(script.spoken)
        assert {element.tag for element in tree.iter()} <= {"speak", "p", "break", "mark"}
