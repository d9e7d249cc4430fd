from contextlib import suppress
from fractions import Fraction
from functools import cache

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_streaming.rtp.h264_units import MAX_UNITS, AccessUnit, NotPassable, access_unit

START = b"\0\0\0\1"
SPS = bytes([0x67, 66, 0xC0, 31])
PPS, IDR, SLICE = b"\x68\xce", b"\x65\x88", b"\x41\x9a"


def ue(value: int) -> str:
    """An Exp-Golomb code."""
    text = f"{value + 1:b}"
    return "0" * (len(text) - 1) + text


def sps(*codes: str, head: bytes = SPS) -> bytes:
    bits = "".join(codes) + "1"
    bits += "0" * (-len(bits) % 8)
    return head + int(bits, 2).to_bytes(len(bits) // 8, "big")


def usual(
    width: int = 20, height: int = 12, order: str = ue(0) + ue(2), tail: str = "11" + "0" + "0", head: bytes = SPS
) -> bytes:
    """An SPS of so many macroblocks."""
    return sps(ue(0), ue(0), order, ue(1), "0", ue(width - 1), ue(height - 1), tail, head=head)


def unit(*parts: bytes) -> bytes:
    return b"".join(START + part for part in parts)


@cache
def encoded(width: int, height: int, profile: str = "baseline", frames: int = 3) -> tuple[bytes, ...]:
    """What x264 makes."""
    context = av.CodecContext.create("libx264", "w")
    context.width, context.height, context.pix_fmt = width, height, "yuv420p"
    context.time_base = Fraction(1, 30)
    context.options = {
        "preset": "ultrafast" if profile == "baseline" else "fast",
        "tune": "zerolatency",
        "profile": profile,
    }
    made = []
    for number in range(frames):
        frame = av.VideoFrame.from_ndarray(np.full((height * 3 // 2, width), 16 + number, np.uint8), format="yuv420p")
        frame.pts = number
        made += [bytes(packet) for packet in context.encode(frame)]
    return tuple(made)


@pytest.mark.parametrize("size", [(320, 180), (1280, 720), (64, 64), (1920, 1080), (50, 34)])
def test_access_units_of_encoders_are_accepted(size: tuple[int, int]) -> None:
    first, *others = encoded(*size)
    assert access_unit(first) == AccessUnit(keyframe=True, size=size)
    assert [access_unit(memoryview(other)) for other in others] == [AccessUnit(keyframe=False, size=None)] * len(others)


@pytest.mark.parametrize("profile", ["main", "high"])
def test_other_profiles_are_refused(profile: str) -> None:
    with pytest.raises(NotPassable, match="constrained baseline is expected"):
        access_unit(encoded(64, 64, profile)[0])


@pytest.mark.parametrize(
    "order",
    [ue(0) + ue(4), ue(2), ue(1) + "0" + ue(1) + ue(2) + ue(3) + ue(0) + ue(1) + ue(0), ue(1) + "1" + ue(0) * 3],
)
def test_every_order_of_pictures_is_read(order: str) -> None:
    assert access_unit(unit(usual(order=order), PPS, IDR)).size == (320, 192)


def test_the_size_is_what_is_shown() -> None:
    cropped = "11" + "1" + ue(1) + ue(2) + ue(3) + ue(4) + "0"
    assert access_unit(unit(usual(tail=cropped), PPS, IDR)).size == (314, 178)


def test_an_emulation_prevention_byte_is_no_part_of_a_number() -> None:
    # Zeros of the numbers themselves: 16 of them in a row are broken by a 3.
    plain = sps(ue(0), ue(0), ue(2), ue(1), "0", ue(255), ue(0), "11", "0", "0")
    escaped = plain[:4] + plain[4:].replace(b"\0\0", b"\0\0\3")
    assert access_unit(unit(escaped, PPS, IDR)).size == (4096, 16)


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (b"", "does not begin with a start code"),
        (b"\0\0\0\x19" + IDR, "does not begin with a start code"),
        (b"x" + unit(IDR), "does not begin with a start code"),
        (START, "a NAL unit is empty"),
        (unit(b"", IDR), "a NAL unit is empty"),
        (unit(SLICE) * (MAX_UNITS + 1), "more than 1000 NAL units"),
        (unit(b"\xe5\x88"), "type 5 is not allowed"),
        (unit(b"\x02\x88"), "type 2 is not allowed"),
        (unit(b"\x78\x88"), "type 24 is not allowed"),
        (unit(usual(), PPS), "it has no picture"),
        (unit(usual(), PPS, IDR, SLICE), "also has non-IDR slices"),
        (unit(IDR), "needs its SPS and PPS before it"),
        (unit(usual(), IDR, PPS), "needs its SPS and PPS before it"),
        (unit(b"\x67\x42\xc0", PPS, IDR), "the SPS is too short"),
        (unit(SPS, PPS, IDR), "the SPS is too short"),
        (unit(usual(head=bytes([0x67, 66, 0x80, 31])), PPS, IDR), "profile 66 with constraints 0x80"),
        (unit(usual(head=bytes([0x67, 77, 0x40, 31])), PPS, IDR), "profile 77"),
        (unit(usual(head=bytes([0x67, 66, 0xC0, 63])), PPS, IDR), "level 63 is not known"),
        (unit(usual(head=bytes([0x67, 66, 0xC0, 9])), PPS, IDR), "level 9 is not known"),
        (unit(usual(tail="01" + "0" + "0"), PPS, IDR), "interlaced"),
        (unit(usual(width=1025), PPS, IDR), "larger than 16,384 pixels"),
        (unit(usual(1, 1, tail="11" + "1" + ue(4) * 4 + "0"), PPS, IDR), "crops all of the picture"),
        (unit(sps("0" * 17, "1"), PPS, IDR), "a number in the SPS is too large"),
    ],
)
def test_unpassable_access_unit_is_refused_with_reason(data: bytes, named: str) -> None:
    with pytest.raises(NotPassable, match=named):
        access_unit(data)


def test_delimiters_and_messages_beside_it_do_no_harm() -> None:
    assert access_unit(unit(b"\x09\x10", usual(), PPS, b"\x06\x05\x01", IDR, IDR, b"\x0c\xff")).keyframe
    assert not access_unit(b"\0\0\1" + SLICE + b"\0\0\0\0").keyframe


@given(st.binary(max_size=300))
@settings(max_examples=100, deadline=None)
def test_arbitrary_bytes_raise_nothing_else(data: bytes) -> None:
    for whole in (data, START + data, unit(SPS + data, PPS, IDR)):
        with suppress(NotPassable):
            access_unit(whole)


@given(st.lists(st.tuples(st.integers(0, 60), st.integers(0, 255)), max_size=4), st.integers(0, 80))
@settings(max_examples=100, deadline=None)
def test_mutated_pictures_raise_nothing_else(changes: list[tuple[int, int]], cut: int) -> None:
    data = bytearray(encoded(64, 64)[0][: cut or None])
    for place, value in changes:
        data[place % len(data)] = value
    with suppress(NotPassable):
        access_unit(bytes(data))
