from aiortc.codecs.vpx import vp8_depayload
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.rtp.vp8 import vp8_payloads


def test_the_first_piece_says_so() -> None:
    assert vp8_payloads(b"abcdefg", 4) == (b"\x10abc", b"\0def", b"\0g")


@given(st.binary(max_size=400), st.integers(2, 100))
def test_every_byte_arrives(frame: bytes, limit: int) -> None:
    payloads = vp8_payloads(frame, limit)
    assert b"".join(map(vp8_depayload, payloads)) == frame
    assert all(len(payload) == limit for payload in payloads[:-1])
