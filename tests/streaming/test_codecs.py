import pytest
from openrois_streaming import codecs
from openrois_streaming.codecs import CodecUnavailable, available_codecs, codec_named


def test_all_codecs_are_available() -> None:
    assert available_codecs() == ("video/H264", "video/VP8", "audio/opus")


@pytest.mark.parametrize("spelling", ["video/H264", "video/h264", "VIDEO/H264"])
def test_media_types_are_case_insensitive(spelling: str) -> None:
    assert codec_named(spelling) == "video/H264"


def test_unknown_media_type_is_refused_with_the_known_ones() -> None:
    with pytest.raises(CodecUnavailable, match=r"'video/AV1'.*video/H264, video/VP8"):
        codec_named("video/AV1")


def test_an_installation_without_x264_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(codecs.LIBRARIES, "video/H264", "libabsent264")
    assert available_codecs() == ("video/VP8", "audio/opus")
    with pytest.raises(CodecUnavailable, match="video/H264 needs libabsent264"):
        codec_named("video/H264")
