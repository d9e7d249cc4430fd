"""Headers of VP8 frames."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.rtp.h264_units import NotPassable
from openrois_streaming.rtp.vp8_frames import vp8_frame


def key_frame(width: int, height: int) -> bytes:
    return b"\x10\x02\x00\x9d\x01\x2a" + width.to_bytes(2, "little") + height.to_bytes(2, "little") + b"data"


def test_a_key_frame_has_a_size() -> None:
    picture = vp8_frame(key_frame(640, 360))
    assert (picture.keyframe, picture.size) == (True, (640, 360))
    assert vp8_frame(key_frame(640 | 0x4000, 360 | 0xC000)).size == (640, 360), "the scale is no part of it"


def test_another_frame_has_none() -> None:
    picture = vp8_frame(b"\x11\x02\x00\x9d")
    assert (picture.keyframe, picture.size) == (False, None)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "more than 3 bytes, not 0"),
        (b"\x10\0\0", "more than 3 bytes, not 3"),
        (b"\x10\0\0\x9d\x01\x2a\x80", "no start code"),
        (b"\x10\0\0\x9d\x01\x2b\x80\x02\x68\x01", "no start code"),
        (key_frame(0, 360), "cannot be 0x360"),
    ],
)
def test_what_is_no_frame_is_refused(data: bytes, text: str) -> None:
    with pytest.raises(NotPassable, match=text):
        vp8_frame(data)


@given(st.binary(max_size=40))
def test_no_bytes_do_any_harm(data: bytes) -> None:
    try:
        picture = vp8_frame(data)
    except NotPassable:
        return
    assert picture.keyframe is (picture.size is not None)
