"""What a client's frames have to be: however a stream is cut, the same passes. Real frames: `tests/conformance`."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.aio.rate import RateLimit
from openrois.http_limits.websocket_frames import (
    BROKEN,
    CONTROL_FRAMES_AT_ONCE,
    CONTROL_FRAMES_PER_SECOND,
    MAX_FRAGMENTS,
    Fault,
    FrameRules,
)
from tests.support.frames import CLOSE, CONTINUATION, PING, PONG, TEXT, closes, frame

MARK = bytes((0x8A, len(BROKEN))) + BROKEN
FRAMES = (
    frame(TEXT, b"hello", mask=b"abcd"),
    frame(TEXT, b"x" * 300),
    frame(TEXT, b"", fin=False) + frame(CONTINUATION, b"y"),
    frame(PING, b"x"),
    closes(1000, b"bye"),
    frame(CLOSE),
    frame(CLOSE, b"\x03"),
    frame(3, b"left to the library", rsv=7),
)
WRONG = (
    frame(TEXT, b"hello", mask=None),
    frame(TEXT, b"hello", form=2),
    frame(TEXT, b"x" * 126, form=8),
    frame(TEXT, length=1 << 63),
    frame(CONTINUATION, b"x"),
    frame(TEXT, fin=False) + frame(TEXT),
    closes(1006),
)


def rules(at_once: int = CONTROL_FRAMES_AT_ONCE) -> FrameRules:
    return FrameRules(RateLimit(at_once, CONTROL_FRAMES_PER_SECOND, lambda: 0.0))


def in_parts(stream: bytes, cuts: list[int]) -> tuple[bytes, Fault | None]:
    """Give a stream in parts, and return what passes of it and what was wrong."""
    judged = rules()
    edges = [0, *sorted(cut % (len(stream) + 1) for cut in cuts), len(stream)]
    passed = b"".join(judged.passed(stream[start:end]) for start, end in pairwise(edges) if start < end)
    return passed, judged.fault


@given(st.lists(st.sampled_from(FRAMES), max_size=6), st.lists(st.integers(min_value=0), max_size=8))
def test_what_is_right_passes_as_it_came(sent: list[bytes], cuts: list[int]) -> None:
    assert in_parts(b"".join(sent), cuts) == (b"".join(sent), None)


@given(
    st.lists(st.sampled_from(FRAMES), max_size=4),
    st.sampled_from(WRONG),
    st.binary(max_size=40),
    st.lists(st.integers(min_value=0), max_size=8),
)
def test_nothing_passes_from_what_is_wrong_on(sent: list[bytes], wrong: bytes, rest: bytes, cuts: list[int]) -> None:
    passed, fault = in_parts(b"".join(sent) + wrong + rest, cuts)
    before = b"".join(sent)
    assert passed.startswith(before)
    assert passed.endswith(MARK)
    # Of two frames that are wrong together the first has passed.
    assert len(passed) - len(before) - len(MARK) in {0, 6}
    assert fault is not None
    assert fault.code == 1002


@given(st.binary(max_size=200), st.lists(st.integers(min_value=0), max_size=8))
def test_any_bytes(stream: bytes, cuts: list[int]) -> None:
    whole = in_parts(stream, [])
    assert in_parts(stream, cuts) == whole
    assert stream.startswith(whole[0].removesuffix(MARK))


def test_an_unfinished_header_waits() -> None:
    judged = rules()
    assert judged.passed(b"\x81") == b""
    assert judged.passed(b"\x85abc") == b""
    assert judged.passed(b"dhe") == b"\x81\x85abcdhe"
    assert judged.passed(b"llo" + b"\x88\x82abcd") == b"llo"
    assert judged.passed(b"\x00") == b""
    assert judged.passed(b"\x00") == MARK
    assert judged.fault == Fault(1002, f"code {0x6162} may not be sent")


def test_the_code_of_a_close_is_read_through_its_mask() -> None:
    assert in_parts(frame(CLOSE, b"\x03\xe8", mask=b"\x03\xee\x55\xaa"), [])[1] is None
    assert in_parts(frame(CLOSE, b"\x03\xee", mask=b"\x03\xe8\x55\xaa"), [])[1] == Fault(
        1002, "code 1006 may not be sent"
    )


def test_a_message_has_so_many_fragments() -> None:
    first, middle, last = frame(TEXT, fin=False), frame(CONTINUATION, fin=False), frame(CONTINUATION)
    assert in_parts((first + middle * (MAX_FRAGMENTS - 2) + last) * 3, [])[1] is None
    passed, fault = in_parts(first + middle * (MAX_FRAGMENTS - 1), [])
    assert len(passed) == 6 * (MAX_FRAGMENTS - 1) + len(MARK)
    assert fault == Fault(1008, "a message may have 1024 fragments at most")


@pytest.mark.parametrize("opcode", [PING, PONG])
def test_there_may_be_so_many_pings_and_pongs(opcode: int) -> None:
    now = 0.0
    judged = FrameRules(RateLimit(CONTROL_FRAMES_AT_ONCE, CONTROL_FRAMES_PER_SECOND, lambda: now))
    judged.passed(frame(opcode) * CONTROL_FRAMES_AT_ONCE)
    now = 1.0
    judged.passed(frame(opcode) * CONTROL_FRAMES_PER_SECOND)
    assert judged.fault is None
    assert judged.passed(frame(opcode) + frame(TEXT)) == MARK
    assert judged.fault == Fault(1008, "too many pings or pongs")
    assert judged.passed(frame(TEXT)) == b""
