"""A record is one line whatever is in it, and no secret is."""

import json
import logging
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.observability import correlation
from openrois.observability.log_lines import HIDDEN, LONGEST, JsonLine, Redaction, TextLine

NASTY = ("a\r\nb", "\x1b[31mred", '"}\n{"level": "error"', "\u202egnirts", "\x7f", "\ud800", "\x00", "tab\there", "")
TOKEN = "eyJhbGciOiJIUzI1NiJ9.eyJzdWIiOiJhbm5hIn0.c2lnbmF0dXJl"
SDP = "v=0\r\no=- 1 1 IN IP4 0.0.0.0\r\na=ice-pwd:asd88fgpdd777uzjYhagZg\r\n"


def record(message: str, *arguments: object, level: int = logging.INFO, exc: bool = False) -> logging.LogRecord:
    info = sys.exc_info() if exc else None
    made = logging.LogRecord("openrois.x", level, __file__, 1, message, arguments, info)
    made.created = 1700000000.1234
    return made


def test_for_people() -> None:
    line = TextLine(Redaction())
    assert line.format(record("the %s is %d", "door", 1)) == "2023-11-14T22:13:20.123Z I openrois.x: the door is 1"
    with correlation.connection("abcd"):
        assert line.format(record("x", level=logging.WARNING)).endswith(" W openrois.x: [abcd] x")


def test_for_machines() -> None:
    line = JsonLine(Redaction())
    assert json.loads(line.format(record("x"))) == {
        "time": "2023-11-14T22:13:20.123Z",
        "level": "info",
        "logger": "openrois.x",
        "message": "x",
    }
    with correlation.connection("abcd"):
        assert json.loads(line.format(record("")))["correlation"] == "abcd"
        assert json.loads(line.format(record("")))["message"] == ""


@given(st.text() | st.sampled_from(NASTY), st.text() | st.sampled_from(NASTY))
def test_one_record_is_one_line(message: str, argument: str) -> None:
    made = record(message.replace("%", "%%") + " %s", argument)
    with correlation.connection(argument):
        text = TextLine(Redaction()).format(made)
        written = JsonLine(Redaction()).format(made)
    assert text.isprintable()
    assert written.isprintable()
    assert json.loads(written)["message"] == f"{message} {argument}"


def test_a_traceback_is_in_the_line() -> None:
    try:
        raise ValueError("first\nsecond")
    except ValueError:
        made = record("failed", exc=True)
        made.stack_info = "the\nstack"
    text = TextLine(Redaction()).format(made)
    assert text.isprintable()
    assert "failed | Traceback" in text
    assert text.endswith("ValueError: first | second | the | stack")
    exception = json.loads(JsonLine(Redaction()).format(made))["exception"]
    assert exception.endswith("ValueError: first\nsecond\nthe\nstack")


def test_a_wrong_call_is_a_line_too() -> None:
    text = TextLine(Redaction()).format(record("%d", "no number"))
    assert "'%d' cannot be written: " in text


def test_secrets_in_a_correlation_are_hidden() -> None:
    with correlation.connection("my own secret"):
        for line in (TextLine(Redaction(["my own secret"])), JsonLine(Redaction(["my own secret"]))):
            assert "own" not in line.format(record("x"))


def test_what_is_long_is_cut_in_the_middle() -> None:
    text = TextLine(Redaction()).format(record("a" * LONGEST + "b" * LONGEST))
    assert len(text) < LONGEST + 100
    assert text.endswith("b")


@pytest.mark.parametrize(
    ("text", "left"),
    [
        (TOKEN, HIDDEN),
        (f"GET /?token={TOKEN}&x=1", f"GET /?token={HIDDEN}&x=1"),
        ("GET /?a=b&token=plain-old-secret HTTP", f"GET /?a=b&token={HIDDEN} HTTP"),
        ("Authorization: Bearer abcdefgh12345", f"Authorization: Bearer {HIDDEN}"),
        ("openrois.bearer.abcdefgh12345", f"openrois.bearer.{HIDDEN}"),
        ('{"credential": "c2VjcmV0"}', f'{{"credential": "{HIDDEN}"}}'),
        (f"offer {SDP}", f"offer {HIDDEN}"),
        (f"offer {SDP!r}", f"offer '{HIDDEN}"),
        ("a=ice-pwd:asd88fgpdd777uzjYhagZg\r\n", f"{HIDDEN}\r\n"),
        ("my own secret stands here", f"{HIDDEN} stands here"),
        ("short and harmless: eyJ.x", "short and harmless: eyJ.x"),
    ],
)
def test_secrets_are_hidden(text: str, left: str) -> None:
    redact = Redaction(["my own secret", "short", ""])
    assert redact(text) == left
    assert json.loads(JsonLine(redact).format(record("%s", text)))["message"] == left


def test_secrets_in_a_traceback_are_hidden() -> None:
    try:
        raise ValueError(TOKEN)
    except ValueError:
        made = record("failed", exc=True)
    for line in (TextLine(Redaction()), JsonLine(Redaction())):
        assert TOKEN not in line.format(made)
        assert HIDDEN in line.format(made)
