import pytest
from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.peer.offer_parameters import h264_level, level_of, with_levels, with_stereo
from openrois_streaming.peer.stream import Stream
from openrois_streaming.stats import Counters

from tests.support.viewing import FedPublisher, FedRendition

SDP = (
    "v=0\r\na=fmtp:0 profile-level-id=42001f\r\n"
    "m=video 9 UDP/TLS/RTP/SAVPF 99 101\r\na=fmtp:99 packetization-mode=1;profile-level-id=42001f\r\n"
    "a=fmtp:101 profile-level-id=42e01f;level-asymmetry-allowed=1\r\n"
    "m=audio 9 UDP/TLS/RTP/SAVPF 96\r\n"
    "m=video 9 UDP/TLS/RTP/SAVPF 99\r\na=fmtp:99 profile-level-id=42001f\r\n"
)


def test_each_section_names_its_own_level() -> None:
    assert with_levels(SDP, [None, None, None]) == SDP
    changed = with_levels(SDP, [42, None, 32])
    assert [part[:6] for part in changed.split("profile-level-id=")[1:]] == ["42001f", "42002a", "42e02a", "420020"]
    assert len(changed) == len(SDP)


def test_there_is_a_level_for_each_section() -> None:
    with pytest.raises(ValueError, match="shorter"):
        with_levels(SDP, [42])


class Sized(FedPublisher):
    """A publisher of pictures of a known size."""

    def __init__(self, rung: Rung | None) -> None:
        super().__init__()
        self._rung = rung

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[FedRendition]:
        (rendition,) = super().renditions(mime_type, fps)
        rendition.rung = self._rung
        return (rendition,)


def stream(rung: Rung | None, *codecs: str) -> Stream:
    return Stream("s", "engine/Video", "video", Sized(rung), codecs, Counters())


def test_the_level_is_that_of_the_largest_pictures() -> None:
    full = Rung(1920, 1080, 60.0, 1, 2)
    assert level_of(stream(full, "video/H264", "video/VP8")) == 42
    assert level_of(stream(full, "video/VP8")) is None
    assert level_of(stream(None, "video/H264")) is None
    uplink = Stream("s", "engine/Video", "video", None, ("video/H264",), Counters())
    assert level_of(uplink) is None


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


def test_section_without_opus_is_unchanged() -> None:
    assert with_stereo(OFFER, [False, False, True]) == OFFER


def test_there_is_a_wish_for_each_section() -> None:
    with pytest.raises(ValueError, match="shorter"):
        with_stereo(OFFER, [True])


@pytest.mark.parametrize(
    ("width", "height", "frame_rate", "level"),
    [
        (320, 180, 30, 31),
        (1280, 720, 30, 31),
        (1280, 720, 60, 32),
        (1920, 1080, 30, 40),
        (1080, 1920, 30, 40),
        (1920, 1080, 60, 42),
        (3840, 2160, 30, 51),
        (3840, 2160, 60, 52),
        (8192, 8192, 300, 62),
    ],
)
def test_the_level_of_what_is_published(width: int, height: int, frame_rate: float, level: int) -> None:
    assert h264_level(width, height, frame_rate) == level
