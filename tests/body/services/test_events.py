"""Server-sent events in pieces of any length."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.services.events import MAX_EVENT, EventReader, MalformedEvents

STREAM = b": hello\r\nevent: a\r\ndata: one\r\n\r\ndata:two\ndata: three\n\n\n\rdata:  four \r\rid: 7\n\ndata: half"


def read(data: bytes, piece: int) -> list[str]:
    reader = EventReader()
    return [event for first in range(0, len(data), piece) for event in reader.add(data[first : first + piece])]


@pytest.mark.parametrize("piece", [1, 2, 3, 5, 8, 1000])
def test_events_are_read_whatever_the_pieces(piece: int) -> None:
    assert read(STREAM, piece) == ["one", "two\nthree", " four "]


@pytest.mark.parametrize("flood", [b"data: " + b"x" * 1000 + b"\n", b"x" * 1000])
def test_an_event_without_end_is_refused(flood: bytes) -> None:
    with pytest.raises(MalformedEvents, match=f"more than {MAX_EVENT} bytes"):
        read(flood * (MAX_EVENT // 500), 4096)


def test_what_is_no_text_is_refused() -> None:
    with pytest.raises(MalformedEvents, match="no text in UTF-8"):
        EventReader().add(b"data: \xff\n\n")


@given(st.binary(max_size=100), st.integers(1, 20))
def test_whatever_comes_pieces_make_no_difference(data: bytes, piece: int) -> None:
    with suppress(MalformedEvents):
        assert read(data, piece) == read(data, 1000)
