import pytest
from openrois_streaming.peer.stereo import with_stereo

OFFER = (
    "v=0\r\n"
    "m=audio 9 UDP/TLS/RTP/SAVPF 96 0\r\na=rtpmap:96 opus/48000/2\r\na=rtpmap:0 PCMU/8000\r\n"
    "m=audio 9 UDP/TLS/RTP/SAVPF 111\r\na=rtpmap:111 opus/48000/2\r\na=fmtp:111 minptime=10\r\n"
    "m=video 9 UDP/TLS/RTP/SAVPF 97\r\na=rtpmap:97 VP8/90000\r\n"
)


def test_opus_is_asked_for_two_channels_where_that_is_wanted() -> None:
    assert with_stereo(OFFER, [False, False, False]) == OFFER
    first = with_stereo(OFFER, [True, False, False])
    assert first == OFFER.replace("opus/48000/2\r\na=rtpmap:0", "opus/48000/2\r\na=fmtp:96 stereo=1\r\na=rtpmap:0")
    second = with_stereo(OFFER, [False, True, False])
    assert second == OFFER.replace("minptime=10", "minptime=10;stereo=1")


def test_what_has_no_opus_stays_as_it_is() -> None:
    assert with_stereo(OFFER, [False, False, True]) == OFFER


def test_there_is_a_wish_for_each_section() -> None:
    with pytest.raises(ValueError, match="shorter"):
        with_stereo(OFFER, [True])
