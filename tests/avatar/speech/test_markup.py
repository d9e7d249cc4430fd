from contextlib import suppress
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_avatar.speech.markup import MAX_DEPTH, MAX_TEXT, MarkupError, plain_text, safe_ssml


def test_text_stays_as_it_is_but_for_control_characters() -> None:
    assert plain_text("Grüß dich,\n世界 🙂 <b> [[x]]\t") == "Grüß dich,\n世界 🙂 <b> [[x]]\t"
    assert plain_text("a\x01+10p\x00b\x9f\ud800c\r") == "a +10p b  c "


def test_a_text_that_is_too_long_is_refused() -> None:
    assert plain_text("x" * MAX_TEXT)
    with pytest.raises(MarkupError, match="at most 4000 characters"):
        plain_text("x" * (MAX_TEXT + 1))
    with pytest.raises(MarkupError, match="at most 4000 characters"):
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
        ('<sub alias="Robotic Interaction">RoIS</sub>', '<speak><sub alias="Robotic Interaction">RoIS</sub></speak>'),
        ('<audio src="/etc/passwd">a</audio>', "<speak>a</speak>"),
        ('<voice name="../../x" gender="female">a</voice>', '<speak><voice gender="female">a</voice></speak>'),
        ("<break time='1s\"/&gt;'/>", "<speak><break></break></speak>"),
        ('<emphasis level="' + "x" * 101 + '">a</emphasis>', "<speak><emphasis>a</emphasis></speak>"),
        ("a<!-- b --><?c d?>", "<speak>a</speak>"),
        ("<![CDATA[<audio src='x'/>]]>", "<speak>&lt;audio src='x'/&gt;</speak>"),
    ],
)
def test_only_harmless_elements_stay(document: str, expected: str) -> None:
    assert safe_ssml(document) == expected


@pytest.mark.parametrize(
    ("document", "named"),
    [
        ("<speak>", "not well-formed"),
        ("a < b", "not well-formed"),
        ("&unknown;", "not well-formed"),
        ("&#1;", "not well-formed"),
        ("<a:b>x</a:b><speak/></speak>", "not well-formed"),
        ('<?xml version="1.0"?><!DOCTYPE speak [<!ENTITY a "b">]><speak>&a;</speak>', "declares a document type"),
        ("<p>" * MAX_DEPTH + "</p>" * MAX_DEPTH, "more than 8 elements inside each other"),
    ],
)
def test_what_is_no_harmless_document_is_refused(document: str, named: str) -> None:
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
        "'/>",
        "&amp;",
        "&#x41;",
        "]]>",
    ]
)


@given(st.lists(pieces | st.text(max_size=5), max_size=12).map("".join))
@settings(max_examples=100, deadline=None)
def test_what_comes_out_is_well_formed_and_known(document: str) -> None:
    with suppress(MarkupError):
        tree = ET.fromstring(safe_ssml(document))
        assert {element.tag for element in tree.iter()} <= {"speak", "p", "break"}
