from typing import Any

import av
import numpy as np
import pytest
from aiortc.codecs.h264 import h264_depayload
from aiortc.codecs.vpx import vp8_depayload
from numpy.typing import NDArray
from openrois_streaming.adaptation.rung import MIN_BITRATE, ladder
from openrois_streaming.publish.encoder import Chunk
from openrois_streaming.publish.video_encoder import VideoEncoder, planar
from openrois_streaming.rtp.payloads import PAYLOAD_LIMIT
from openrois_streaming.source import stamp
from openrois_streaming.source.source import PixelFormat, RawVideo, picture_shape

from tests.support.pictures import Decoder, Scene, psnr

pytestmark = pytest.mark.extra(name="streaming")

H264, VP8 = "video/H264", "video/VP8"
both = pytest.mark.parametrize("mime_type", [H264, VP8])

# The monotonic clock of a machine that has been up for eleven days.
START = 1_000_000.0


def encode(
    encoder: VideoEncoder, scene: Scene, count: int, fps: float, *, first: int = 0, forced: tuple[int, ...] = ()
) -> list[Chunk]:
    """Encode pictures `first` to `first + count`, and check that each gives exactly one chunk of its own time."""
    chunks = []
    for number in range(first, first + count):
        moment = START + number / fps
        [chunk] = encoder.encode(scene.picture(number, moment), key_frame=number in forced)
        assert (chunk.pts, chunk.captured_at) == (round(moment * 90_000), moment)
        chunks.append(chunk)
    return chunks


def kbits_per_second(chunks: list[Chunk], fps: float) -> float:
    return sum(len(chunk.data) for chunk in chunks) * 8 / 1000 * fps / len(chunks)


def nal_types(access_unit: bytes) -> list[int]:
    return [part[0] & 31 for part in access_unit.split(b"\x00\x00\x01")[1:]]


@both
@pytest.mark.parametrize("fps", [15, 30, 60])
def test_each_frame_gives_one_chunk_at_once_and_the_bit_rate_is_met_at_any_pace(mime_type: str, fps: int) -> None:
    encoder = VideoEncoder(mime_type, bitrate=150_000, frame_rate=30)
    chunks = encode(encoder, Scene(), 3 * fps, fps)
    assert [chunk.keyframe for chunk in chunks] == [True] + [False] * (len(chunks) - 1)
    assert kbits_per_second(chunks[fps:], fps) == pytest.approx(150, rel=0.3)


@both
def test_a_key_frame_comes_when_it_is_forced_and_a_viewer_can_start_there(mime_type: str) -> None:
    scene = Scene()
    chunks = encode(VideoEncoder(mime_type, bitrate=500_000, frame_rate=30), scene, 20, 30, forced=(7, 15))
    assert [number for number, chunk in enumerate(chunks) if chunk.keyframe] == [0, 7, 15]
    decoder = Decoder(mime_type)
    decoded = [plane for chunk in chunks[7:] for plane in decoder.decode(chunk.data)]
    assert len(decoded) == 13
    assert psnr(decoded[-1], scene.luma(19)) > 28


def test_h264_is_constrained_baseline_with_parameter_sets_in_each_key_frame() -> None:
    chunks = encode(VideoEncoder(H264, bitrate=500_000, frame_rate=30), Scene(), 6, 30, forced=(3,))
    for chunk in chunks:
        types = nal_types(chunk.data)
        if chunk.keyframe:
            assert types[:2] == [7, 8]
            assert types[-1] == 5
            # profile_idc 66 with constraint_set0 and constraint_set1 (ISO/IEC 14496-10 A.2.1)
            assert chunk.data[5] == 66
            assert chunk.data[6] & 0xC0 == 0xC0
        else:
            assert types == [1], "one slice, predicted"


@both
def test_payloads_depacketised_by_aiortc_can_be_decoded(mime_type: str) -> None:
    depayload = h264_depayload if mime_type == H264 else vp8_depayload
    scene, decoder = Scene(), Decoder(mime_type)
    chunks = encode(VideoEncoder(mime_type, bitrate=600_000, frame_rate=30), scene, 10, 30, forced=(5,))
    most = 0
    for number, chunk in enumerate(chunks):
        assert all(len(payload) <= PAYLOAD_LIMIT for payload in chunk.payloads)
        most = max(most, len(chunk.payloads))
        [plane] = decoder.decode(b"".join(map(depayload, chunk.payloads)))
        assert psnr(plane, scene.luma(number)) > 26
    assert most > 2, "a key frame that takes several packets was among them"


def test_h264_follows_the_bit_rate_without_a_key_frame() -> None:
    encoder, scene = VideoEncoder(H264, bitrate=400_000, frame_rate=30), Scene()
    chunks = encode(encoder, scene, 40, 30)
    for bitrate, first in ((800_000, 40), (200_000, 100)):
        encoder.set_bitrate(bitrate)
        then = encode(encoder, scene, 60, 30, first=first)
        assert not any(chunk.keyframe for chunk in then)
        assert kbits_per_second(then[20:], 30) == pytest.approx(bitrate / 1000, rel=0.3)
    assert chunks[0].keyframe


def test_vp8_starts_anew_for_another_bit_rate_but_not_for_a_little() -> None:
    encoder, scene = VideoEncoder(VP8, bitrate=400_000, frame_rate=30), Scene()
    encode(encoder, scene, 5, 30)
    encoder.set_bitrate(430_000)
    assert not any(chunk.keyframe for chunk in encode(encoder, scene, 5, 30, first=5))
    encoder.set_bitrate(200_000)
    then = encode(encoder, scene, 60, 30, first=10)
    assert [chunk.keyframe for chunk in then] == [True] + [False] * 59
    assert kbits_per_second(then[20:], 30) == pytest.approx(200, rel=0.3)


@both
def test_a_bit_rate_out_of_bounds_is_brought_within(mime_type: str) -> None:
    scene = Scene()
    least = encode(VideoEncoder(mime_type, bitrate=1, frame_rate=30), scene, 60, 30)
    assert kbits_per_second(least[20:], 30) < 2.5 * MIN_BITRATE / 1000
    most = VideoEncoder(mime_type, bitrate=10**9, frame_rate=30, max_bitrate=700_000)
    assert kbits_per_second(encode(most, scene, 40, 30)[20:], 30) < 1.3 * 700


@both
def test_a_key_frame_is_no_burst_that_holds_up_what_follows(mime_type: str) -> None:
    chunks = encode(VideoEncoder(mime_type, bitrate=600_000, frame_rate=30), Scene(), 40, 30, forced=(20, 30))
    burst = max(len(chunk.data) for chunk in chunks) * 8 / 600_000
    assert burst < 0.35, "seconds of the bit rate"


@both
def test_the_codec_is_opened_before_the_first_picture_of_the_size_that_is_expected(
    mime_type: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[object] = []
    create = av.CodecContext.create

    def counted(*arguments: Any) -> Any:
        made.append(create(*arguments))
        return made[-1]

    monkeypatch.setattr(av.CodecContext, "create", counted)
    encoder = VideoEncoder(mime_type, bitrate=300_000, frame_rate=30, size=(320, 180))
    assert len(made) == 1
    chunks = encode(encoder, Scene(320, 180), 3, 30)
    assert [chunk.keyframe for chunk in chunks] == [True, False, False]
    assert len(made) == 1, "that is the one that encodes"
    encode(encoder, Scene(160, 96), 4, 30, first=3)
    assert len(made) == 2, "another size is another codec"


@both
def test_a_pause_of_the_source_changes_neither_bit_rate_nor_pictures(mime_type: str) -> None:
    encoder, scene = VideoEncoder(mime_type, bitrate=300_000, frame_rate=30), Scene()
    encode(encoder, scene, 40, 30)
    then = encode(encoder, scene, 60, 30, first=40 + 30 * 20)
    assert not any(chunk.keyframe for chunk in then)
    assert kbits_per_second(then[20:], 30) == pytest.approx(300, rel=0.3)


@both
def test_a_frame_of_another_size_begins_with_a_key_frame(mime_type: str) -> None:
    encoder, decoder = VideoEncoder(mime_type, bitrate=500_000, frame_rate=30), Decoder(mime_type)
    chunks = encode(encoder, Scene(320, 180), 3, 30) + encode(encoder, Scene(480, 270), 3, 30, first=3)
    assert [chunk.keyframe for chunk in chunks] == [True, False, False] * 2
    shapes = [plane.shape for chunk in chunks for plane in decoder.decode(chunk.data)]
    assert shapes == [(180, 320)] * 3 + [(270, 480)] * 3


@both
def test_frames_of_one_moment_or_out_of_order_still_get_growing_times(mime_type: str) -> None:
    encoder, scene = VideoEncoder(mime_type, bitrate=500_000, frame_rate=30), Scene()
    pts = []
    for number, moment in enumerate([10.0, 10.0, 9.5, 10.1]):
        [chunk] = encoder.encode(scene.picture(number, moment), key_frame=False)
        pts.append(chunk.pts)
    assert pts == [900_000, 900_001, 900_002, 909_000]


def coloured(pixel_format: PixelFormat, width: int, height: int) -> RawVideo:
    data = np.zeros(picture_shape(pixel_format, width, height), np.uint8)
    data[: height // 2, :, 0] = 200
    data[height // 2 :, :, 2] = 200
    return RawVideo(data, pixel_format, width, height, 0, START)


def semi_planar(i420: NDArray[np.uint8], width: int, height: int) -> RawVideo:
    """An I420 picture in NV12."""
    u, v = i420.reshape(-1)[width * height :].reshape(2, height // 2, width // 2)
    return RawVideo(np.vstack([i420[:height], np.dstack([u, v]).reshape(-1, width)]), "nv12", width, height, 0, START)


def test_every_format_becomes_the_same_i420_picture() -> None:
    first, second = planar(coloured("bgra", 64, 32)), planar(coloured("bgr24", 64, 32))
    assert np.array_equal(first, second)
    mirrored = np.ascontiguousarray(coloured("bgr24", 64, 32).data[:, :, ::-1])
    assert np.array_equal(first, planar(RawVideo(mirrored, "rgb24", 64, 32, 0, START)))
    assert np.array_equal(first, planar(semi_planar(first, 64, 32)))
    # Blue above, red below (ITU-R BT.601, limited range): luma, then U and V of both halves.
    assert first[0, 0] == pytest.approx(16 + 0.098 * 200, abs=2)
    assert first[31, 0] == pytest.approx(16 + 0.257 * 200, abs=2)
    u, v = first.reshape(-1)[64 * 32 :].reshape(2, 16, 32)
    assert u[0, 0] > 200 > 128 > u[-1, 0]
    assert v[0, 0] < 128 < 200 < v[-1, 0]


def test_i420_is_taken_as_it_is() -> None:
    raw = Scene().picture(0, START)
    assert planar(raw) is raw.data


@both
@pytest.mark.parametrize("pixel_format", ["bgra", "bgr24"])
def test_odd_sizes_lose_a_row_and_a_column(mime_type: str, pixel_format: PixelFormat) -> None:
    raw = coloured(pixel_format, 161, 91)
    [chunk] = VideoEncoder(mime_type, bitrate=500_000, frame_rate=30).encode(raw, key_frame=False)
    [plane] = Decoder(mime_type).decode(chunk.data)
    assert plane.shape == (90, 160)


@both
@pytest.mark.parametrize("height", [88, 90, 270])
def test_colours_stay_where_they_are_at_any_height(mime_type: str, height: int) -> None:
    [chunk] = VideoEncoder(mime_type, bitrate=500_000, frame_rate=30).encode(
        coloured("bgr24", 160, height), key_frame=True
    )
    decoder: Any = av.CodecContext.create({"video/H264": "h264", "video/VP8": "vp8"}[mime_type], "r")
    frames: list[av.VideoFrame] = decoder.decode(av.Packet(chunk.data)) + decoder.decode(None)
    pixels = frames[0].to_ndarray(format="bgr24").astype(int)
    for row, (blue, red) in {1: (200, 0), height // 2 - 6: (200, 0), height // 2 + 6: (0, 200), -2: (0, 200)}.items():
        assert pixels[row, 80, 0] == pytest.approx(blue, abs=8)
        assert pixels[row, 80, 2] == pytest.approx(red, abs=8)


@both
def test_a_picture_that_no_codec_takes_is_a_failure(mime_type: str) -> None:
    with pytest.raises(av.FFmpegError):
        VideoEncoder(mime_type, bitrate=500_000, frame_rate=30).encode(coloured("bgra", 20_000, 2), key_frame=False)


def test_a_bottom_up_view_is_encoded_the_right_way_up() -> None:
    upright = coloured("bgra", 64, 32)
    flipped = RawVideo(np.ascontiguousarray(upright.data[::-1])[::-1], "bgra", 64, 32, 0, START)
    assert not flipped.data.flags.c_contiguous
    assert np.array_equal(planar(flipped), planar(upright))


def test_a_strided_view_is_encoded_without_its_padding() -> None:
    padded = np.full((32, 80, 4), 255, np.uint8)
    padded[:, :64] = coloured("bgra", 64, 32).data
    view = RawVideo(padded[:, :64], "bgra", 64, 32, 0, START)
    assert np.array_equal(planar(view), planar(coloured("bgra", 64, 32)))


@both
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (640, 360)])
def test_a_stamp_can_be_read_on_every_rung_at_its_lowest_rate(mime_type: str, size: tuple[int, int]) -> None:
    scene = Scene(*size)
    for rung in ladder(*size, 30):
        encoder = VideoEncoder(
            mime_type,
            bitrate=max(rung.min_bitrate, 80_000),
            frame_rate=30,
            max_bitrate=rung.max_bitrate,
            halvings=rung.halvings,
        )
        decoder = Decoder(mime_type)
        for number in range(8):
            raw = stamp.stamped(scene.picture(number, START + number / 30), 1_800_000_000 + number)
            [chunk] = encoder.encode(raw, key_frame=False)
            [plane] = decoder.decode(chunk.data)
            assert plane.shape == (rung.height, rung.width)
            assert stamp.read(plane) == stamp.Stamp.at(number, 1_800_000_000 + number)


@pytest.mark.parametrize(("halvings", "size"), [(0, (206, 106)), (1, (102, 52)), (2, (50, 26))])
@pytest.mark.parametrize("pixel_format", ["i420", "nv12", "bgra", "bgr24"])
def test_halving_keeps_colours_and_cuts_off_what_is_left_over(
    pixel_format: PixelFormat, halvings: int, size: tuple[int, int]
) -> None:
    raw = coloured("bgr24" if pixel_format == "bgr24" else "bgra", 206, 106)
    if pixel_format == "i420":
        raw = RawVideo(planar(raw), "i420", 206, 106, 0, START)
    if pixel_format == "nv12":
        raw = semi_planar(planar(raw), 206, 106)
    small = planar(raw, halvings)
    width, height = size
    assert small.shape == (height * 3 // 2, width)
    assert small.flags.c_contiguous
    u, v = small.reshape(-1)[width * height :].reshape(2, height // 2, width // 2)
    assert u[0, 0] > 200 > 128 > u[-1, 0]
    assert v[0, 0] < 128 < 200 < v[-1, 0]


def test_a_much_lower_rate_starts_h264_anew_because_its_bursts_would_be_too_long() -> None:
    encoder, scene = VideoEncoder(H264, bitrate=1_000_000, frame_rate=30), Scene()
    encode(encoder, scene, 10, 30)
    encoder.set_bitrate(200_000)
    then = encode(encoder, scene, 30, 30, first=10)
    assert [chunk.keyframe for chunk in then] == [True] + [False] * 29
