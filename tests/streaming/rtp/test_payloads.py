import pytest
from aiortc.codecs.h264 import h264_depayload
from aiortc.codecs.vpx import vp8_depayload
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.rtp.payloads import PAYLOAD_LIMIT, h264_payloads, payloads_of, vp8_payloads


def test_each_media_type_has_its_format() -> None:
    assert payloads_of("video/H264", b"\0\0\1\x41") == (b"\x41",)
    assert [len(each) for each in payloads_of("video/VP8", bytes(2000))] == [PAYLOAD_LIMIT, 2000 - PAYLOAD_LIMIT + 2]
    assert payloads_of("audio/opus", bytes(2000)) == (bytes(2000),)
    with pytest.raises(ValueError, match="video/AV1"):
        payloads_of("video/AV1", b"")


SPS, PPS = b"\x67\x42\xc0\x1f", b"\x68\xce"


def annex_b(*units: bytes) -> bytes:
    return b"".join(b"\0\0\0\1" + unit for unit in units)


def test_a_unit_that_fits_is_a_payload() -> None:
    assert h264_payloads(b"\0\0\1\x41slice", 100) == (b"\x41slice",)


def test_small_units_go_together_and_the_most_important_says_how_important_they_are() -> None:
    sei = b"\x06text"
    (payload,) = h264_payloads(annex_b(sei, SPS, PPS), 100)
    assert payload[0] == 0x60 | 24
    assert h264_depayload(payload) == annex_b(sei, SPS, PPS)


def test_unit_that_does_not_fit_begins_another_payload() -> None:
    units = (b"\x41" + b"a" * 39, b"\x41" + b"b" * 39, b"\x41" + b"c" * 39)
    assert h264_payloads(annex_b(*units), 90)[0] == b"\x58\0\x28" + units[0] + b"\0\x28" + units[1]
    assert h264_payloads(annex_b(*units), 84) == units
    assert h264_payloads(annex_b(*units), 40) == units


def test_a_large_unit_is_cut_into_fragments_of_one_length() -> None:
    unit = b"\x65" + bytes(range(1, 251)) * 2
    payloads = h264_payloads(annex_b(SPS, PPS, unit), 102)
    assert payloads[0][0] & 31 == 24
    fragments = payloads[1:]
    assert [len(fragment) for fragment in fragments] == [102, 102, 102, 102, 102]
    assert [fragment[:2] for fragment in fragments] == [b"\x7c\x85", *[b"\x7c\x05"] * 3, b"\x7c\x45"]
    assert b"".join(map(h264_depayload, payloads)) == annex_b(SPS, PPS, unit)


@pytest.mark.parametrize("data", [b"", b"no start code", b"\0\0\1", b"\0\0\1\0\0\1"])
def test_nothing_comes_of_nothing(data: bytes) -> None:
    assert h264_payloads(data, 100) == ()


@given(st.lists(st.integers(1, 400), max_size=8), st.integers(60, 200))
def test_every_byte_arrives_and_no_payload_is_too_long(lengths: list[int], limit: int) -> None:
    units = [bytes((0x41 + number,)) + b"x" * length for number, length in enumerate(lengths)]
    payloads = h264_payloads(annex_b(*units), limit)
    assert all(len(payload) <= limit for payload in payloads)
    assert b"".join(map(h264_depayload, payloads)) == annex_b(*units)


@given(st.binary(max_size=300))
def test_any_bytes_are_cut(data: bytes) -> None:
    assert all(0 < len(payload) <= 50 for payload in h264_payloads(data, 50))


def test_the_first_piece_says_so() -> None:
    assert vp8_payloads(b"abcdefg", 4) == (b"\x10abc", b"\0def", b"\0g")


@given(st.binary(max_size=400), st.integers(2, 100))
def test_every_byte_arrives(frame: bytes, limit: int) -> None:
    payloads = vp8_payloads(frame, limit)
    assert b"".join(map(vp8_depayload, payloads)) == frame
    assert all(len(payload) == limit for payload in payloads[:-1])
