import pytest
from openrois_streaming.rtp.payloads import PAYLOAD_LIMIT, payloads_of


def test_each_media_type_has_its_format() -> None:
    assert payloads_of("video/H264", b"\0\0\1\x41") == (b"\x41",)
    assert [len(each) for each in payloads_of("video/VP8", bytes(2000))] == [PAYLOAD_LIMIT, 2000 - PAYLOAD_LIMIT + 2]
    assert payloads_of("audio/opus", bytes(2000)) == (bytes(2000),)
    with pytest.raises(ValueError, match="video/AV1"):
        payloads_of("video/AV1", b"")
