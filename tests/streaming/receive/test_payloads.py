import pytest
from aiortc.codecs.h264 import H264Encoder, h264_depayload
from aiortc.codecs.vpx import VpxPayloadDescriptor
from hypothesis import example, given
from hypothesis import strategies as st
from openrois_streaming.receive.payloads import Depacketizer, MalformedPayload, Piece, h264_piece, vp8_piece

START = b"\x00\x00\x00\x01"


class TestVp8:
    def test_a_key_frame_begins(self) -> None:
        assert vp8_piece(b"\x10\x00abc") == Piece(b"\x00abc", begins=True, key=True, opens_key=True)

    def test_another_picture_begins(self) -> None:
        assert vp8_piece(b"\x10\x01abc") == Piece(b"\x01abc", begins=True, key=False, opens_key=False)

    @pytest.mark.parametrize("first", [b"\x00", b"\x11", b"\x01"])
    def test_continuation_is_no_beginning(self, first: bytes) -> None:
        assert vp8_piece(first + b"\x00") == Piece(b"\x00", begins=False, key=False, opens_key=False)

    @pytest.mark.parametrize(
        "descriptor",
        [
            VpxPayloadDescriptor(1, 0, picture_id=5),
            VpxPayloadDescriptor(1, 0, picture_id=500, tl0picidx=3),
            VpxPayloadDescriptor(1, 0, tl0picidx=3, tid=(1, 0)),
            VpxPayloadDescriptor(1, 0, keyidx=3),
        ],
        ids=str,
    )
    def test_extensions_are_left_out(self, descriptor: VpxPayloadDescriptor) -> None:
        assert vp8_piece(bytes(descriptor) + b"\x00data").data == b"\x00data"

    def test_a_short_picture_id_has_one_byte(self) -> None:
        assert vp8_piece(b"\x90\x80\x7f\x01").data == b"\x01"

    @pytest.mark.parametrize("payload", [b"", b"\x10", b"\x90\x80", b"\x90\x80\x80\x01", b"\x90\xf0\x80\x01\x02\x03"])
    def test_truncated_payload_is_refused(self, payload: bytes) -> None:
        with pytest.raises(MalformedPayload):
            vp8_piece(payload)


class TestH264:
    def test_a_unit_by_itself(self) -> None:
        assert h264_piece(b"\x41\x9abc") == Piece(START + b"\x41\x9abc", begins=True, key=False, opens_key=False)
        assert h264_piece(b"\x65\x88bc") == Piece(START + b"\x65\x88bc", begins=True, key=True, opens_key=False)
        assert h264_piece(b"\x67abc") == Piece(START + b"\x67abc", begins=True, key=False, opens_key=True)

    def test_a_slice_that_is_not_the_first(self) -> None:
        assert not h264_piece(b"\x65\x08bc").begins
        assert not h264_piece(b"\x78\x00\x03\x41\x08a\x00\x02\x41\x88").begins
        assert not h264_piece(b"\x78\x00\x01\x41").begins

    def test_an_aggregate(self) -> None:
        payload = b"\x78\x00\x02\x67a\x00\x02\x68b\x00\x03\x65cd"
        whole = START + b"\x67a" + START + b"\x68b" + START + b"\x65cd"
        assert h264_piece(payload) == Piece(whole, begins=True, key=True, opens_key=True)

    def test_fragments(self) -> None:
        assert h264_piece(b"\x7c\x85\x88b") == Piece(START + b"\x65\x88b", begins=True, key=True, opens_key=False)
        assert h264_piece(b"\x7c\x05cd") == Piece(b"cd", begins=False, key=True, opens_key=False)
        assert h264_piece(b"\x5c\x41ef") == Piece(b"ef", begins=False, key=False, opens_key=False)

    def test_payloads_of_another_packetiser_are_assembled(self) -> None:
        units = [b"\x67" + bytes(20), b"\x68" + bytes(5), b"\x65" + bytes(range(256)) * 20]
        payloads = H264Encoder._packetize(iter(units))
        assert b"".join(h264_piece(each).data for each in payloads) == b"".join(START + unit for unit in units)

    @pytest.mark.parametrize(
        "payload",
        [
            b"",
            b"\x41",
            b"\x5c\x85",
            b"\x79ab",
            b"\x40ab",
            b"\x78\x00",
            b"\x78\x00\x01",
            b"\x78\x00\x00",
            b"\x78\x00\x05ab",
        ],
    )
    def test_truncated_or_unknown_payload_is_refused(self, payload: bytes) -> None:
        with pytest.raises(MalformedPayload):
            h264_piece(payload)

    @given(st.binary(max_size=200))
    @example(b"\x78\x00\x01\x41\x00\x01\x41")
    def test_depacketiser_agrees_with_aiortc(self, payload: bytes) -> None:
        try:
            data = h264_piece(payload).data
        except MalformedPayload:
            return
        assert data == h264_depayload(payload)


@pytest.mark.parametrize("depacketize", [vp8_piece, h264_piece])
@given(st.binary(max_size=1500))
def test_any_bytes_are_read_or_refused(depacketize: Depacketizer, payload: bytes) -> None:
    try:
        piece = depacketize(payload)
    except MalformedPayload:
        return
    assert len(piece.data) <= 4 * len(payload) + 4
    assert piece.begins or not piece.opens_key
