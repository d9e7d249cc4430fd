"""Frames: what is packed is read, and whatever else comes is refused in bounded words."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.cluster.frames import (
    CUT_FRAME,
    MAX_GREETING,
    Accept,
    Address,
    Beat,
    Dial,
    Frame,
    FrameFault,
    Kind,
    pack_close,
    pack_frame,
    pack_grant,
    pack_texts,
    parse_close,
    parse_frame,
    parse_grant,
    parse_said,
    parse_texts,
)

pytestmark = pytest.mark.extra(name="cluster")
LINK = "0123456789abcdef"
NUMBERS = st.integers(0, 2**64 - 1)


@given(st.sampled_from(list(Kind)), NUMBERS, st.binary())
def test_a_frame_is_read_as_it_was_packed(kind: Kind, number: int, body: bytes) -> None:
    assert parse_frame(pack_frame(kind, number, body)) == Frame(kind, number, body)


def test_a_cut_is_a_frame() -> None:
    assert parse_frame(CUT_FRAME) == Frame(Kind.CUT, 0, b"")


@pytest.mark.parametrize("data", [b"", b"\x02", b"\x02\0\0\0\0\0\0\0", b"\0" * 9, b"\x0a" + b"\0" * 8, b"\xff" * 20])
def test_what_is_no_frame_is_refused(data: bytes) -> None:
    with pytest.raises(FrameFault):
        parse_frame(data)


@given(st.lists(st.binary(), min_size=1))
def test_several_messages_are_read_as_they_were_packed(texts: list[bytes]) -> None:
    assert parse_texts(pack_texts(texts)) == texts


@pytest.mark.parametrize("body", [b"", b"\0\0\0", b"\0\0\0\x01", b"\0\0\0\0\0\0", b"\xff\xff\xff\xffx"])
def test_several_messages_that_are_cut_short_are_refused(body: bytes) -> None:
    with pytest.raises(FrameFault):
        parse_texts(body)


@given(NUMBERS)
def test_a_credit_is_read_as_it_was_packed(granted: int) -> None:
    assert parse_grant(pack_grant(granted)) == granted
    with pytest.raises(FrameFault):
        parse_grant(pack_grant(granted) + b"x")


@given(st.integers(0, 65535), st.text(alphabet=st.characters(exclude_categories=["Cs"]), max_size=30))
def test_a_close_is_read_as_it_was_packed(code: int, reason: str) -> None:
    assert parse_close(pack_close(code, reason)) == (code, reason)


def test_a_reason_is_cut_to_that_of_a_websocket() -> None:
    assert parse_close(pack_close(1000, "日" * 100)) == (1000, "日" * 41)
    assert parse_close(b"\x03\xe8" + b"\xff" * 200)[1] == "\ufffd" * 41
    with pytest.raises(FrameFault):
        parse_close(b"\x03")


def test_later_versions_may_add_fields() -> None:
    text = f'{{"link": "{LINK}", "stream": 7, "window": 65536, "later": [1]}}'
    assert parse_said(Accept, text.encode()) == Accept(link=LINK, stream=7, window=65536)
    assert parse_said(Address, text.encode()) == Address(link=LINK, stream=7)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"link": "*", "stream": 0, "window": 65536}',
        '{"link": "0123456789abcde>", "stream": 0, "window": 65536}',
        '{"link": "0123456789abcdef\\n", "stream": 0, "window": 65536}',
        '{"link": "0123456789abcdef", "stream": -1, "window": 65536}',
        '{"link": "0123456789abcdef", "stream": 0, "window": 0}',
    ],
)
def test_an_address_leads_to_a_stream_and_nowhere_else(text: str) -> None:
    with pytest.raises(FrameFault, match="no Accept"):
        parse_said(Accept, text.encode())


def test_what_is_not_understood_is_not_repeated() -> None:
    with pytest.raises(FrameFault) as raised:
        parse_said(Dial, b'{"hello": {"token": "canary"}, "gateway": "canary"}')
    assert "canary" not in str(raised.value)
    assert raised.value.__suppress_context__
    with pytest.raises(FrameFault, match="is too long"):
        parse_said(Beat, b" " * (MAX_GREETING + 1))


@given(st.binary() | st.builds(pack_frame, st.sampled_from(list(Kind)), NUMBERS, st.binary()))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    readers = (
        lambda frame: parse_texts(frame.body),
        lambda frame: parse_grant(frame.body),
        lambda frame: parse_close(frame.body),
        lambda frame: parse_said(Dial, frame.body),
    )
    for read in readers:
        with suppress(FrameFault):
            assert read(parse_frame(data)) is not None
