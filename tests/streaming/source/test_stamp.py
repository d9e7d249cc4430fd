import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source import stamp
from openrois_streaming.source.source import PixelFormat, RawVideo, picture_shape
from openrois_streaming.source.stamp import NUMBER_MODULUS, TIME_MODULUS, Stamp

from tests.support.pictures import Decoder, Scene

VECTORS = json.loads((Path(__file__).parent / "stamp_vectors.json").read_text())
WALL = 1_795_012_345.6789

numbers = st.integers(0, NUMBER_MODULUS - 1)
times = st.integers(0, TIME_MODULUS - 1)


@pytest.mark.parametrize("vector", VECTORS)
def test_the_vectors_that_other_readers_are_tested_with(vector: dict[str, int | str]) -> None:
    made = Stamp(int(vector["number"]), int(vector["time"]))
    assert "".join(map(str, made.bits())) == vector["bits"]
    assert Stamp.from_bits(np.array([int(bit) for bit in str(vector["bits"])], np.uint8)) == made


@settings(max_examples=50, deadline=None)
@given(numbers, times, st.integers(0, 79))
def test_a_wrong_cell_is_noticed(number: int, time: int, cell: int) -> None:
    bits = Stamp(number, time).bits()
    bits[cell] ^= 1
    assert Stamp.from_bits(bits) is None


@settings(max_examples=40, deadline=None)
@given(numbers, times, st.integers(160, 2000), st.integers(16, 1100), st.sampled_from([2, 3, 4]))
def test_written_stamp_is_read_at_any_size(number: int, time: int, width: int, height: int, channels: int) -> None:
    shape = (height, width) if channels == 2 else (height, width, channels)
    pixels = np.full(shape, 99, np.uint8)
    wall = time / stamp.TIME_UNITS_PER_SECOND
    stamp.write(pixels, number, wall)
    luma = pixels if pixels.ndim == 2 else np.ascontiguousarray(pixels[:, :, 1])
    assert stamp.read(luma) == Stamp(number, time)
    assert np.all(pixels[: height - max(8, height * 8 // 360)] == 99)


def test_the_cells_are_where_other_readers_look_for_them() -> None:
    luma = np.full((720, 854), 128, np.uint8)
    stamp.write(luma, 12345, WALL)
    bits = Stamp.at(12345, WALL).bits()
    for cell in range(80):
        block = luma[-16:, cell * 854 // 80 : (cell + 1) * 854 // 80]
        assert np.all(block == (235 if bits[cell] else 16))
    assert np.all(luma[:-16] == 128)


def test_alpha_is_left_alone() -> None:
    pixels = np.full((90, 160, 4), 77, np.uint8)
    stamp.write(pixels, 1, WALL)
    assert np.all(pixels[:, :, 3] == 77)
    assert set(np.unique(pixels[-8:, :, :3])) == {0, 255}


def test_number_and_time_wrap() -> None:
    made = Stamp.at(NUMBER_MODULUS + 5, (TIME_MODULUS + 7) / stamp.TIME_UNITS_PER_SECOND)
    assert (made.number, made.time) == (5, 7)


def test_the_age_of_a_picture_is_known_across_the_wrap() -> None:
    assert Stamp.at(0, WALL).age(WALL + 0.0123) == pytest.approx(0.0123, abs=1e-9)
    assert Stamp.at(0, WALL).age(WALL - 2.5) == pytest.approx(-2.5)
    wrap = TIME_MODULUS / stamp.TIME_UNITS_PER_SECOND
    assert Stamp.at(0, wrap - 0.01).age(wrap + 0.02) == pytest.approx(0.03)


@pytest.mark.parametrize("size", [(15, 160), (90, 158)])
def test_a_picture_that_is_too_small_has_no_stamp(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="too small"):
        stamp.write(np.zeros(size, np.uint8), 0, WALL)
    assert stamp.read(np.zeros(size, np.uint8)) is None
    raw = RawVideo(np.zeros((*size, 4), np.uint8), "bgra", size[1], size[0], 1, 0.0)
    assert stamp.stamped(raw, WALL) is raw
    assert not raw.data.any()


@pytest.mark.parametrize("value", [0, 128, 255])
def test_a_flat_picture_has_no_stamp(value: int) -> None:
    assert stamp.read(np.full((360, 640), value, np.uint8)) is None


def test_a_picture_that_was_halved_is_read_over_any_content() -> None:
    for content in (0, 128, 255):
        luma = np.full((360, 640), content, np.uint8)
        stamp.write(luma, 4711, WALL)
        halved = np.asarray(cv2.resize(luma, (320, 180), interpolation=cv2.INTER_AREA), np.uint8)
        assert stamp.read(halved) == Stamp.at(4711, WALL)


def test_a_picture_that_was_enlarged_is_read() -> None:
    luma = np.full((360, 640), 128, np.uint8)
    stamp.write(luma, 4711, WALL)
    assert stamp.read(np.asarray(cv2.resize(luma, (1920, 1080)), np.uint8)) == Stamp.at(4711, WALL)


def _raw(pixel_format: PixelFormat, width: int = 640, height: int = 360) -> RawVideo:
    data = np.full(picture_shape(pixel_format, width, height), 90, np.uint8)
    return RawVideo(data, pixel_format, width, height, sequence=99, captured_at=5.0)


def _luma(raw: RawVideo) -> NDArray[np.uint8]:
    return raw.data[: raw.height] if raw.data.ndim == 2 else np.ascontiguousarray(raw.data[:, :, 0])


@pytest.mark.parametrize("pixel_format", ["bgra", "bgr24", "rgb24", "i420", "nv12"])
def test_a_raw_picture_is_stamped_in_its_own_pixels(pixel_format: PixelFormat) -> None:
    raw = _raw(pixel_format)
    assert stamp.stamped(raw, WALL) is raw
    assert stamp.read(_luma(raw)) == Stamp.at(99, WALL)


@pytest.mark.parametrize("pixel_format", ["bgra", "i420", "nv12"])
def test_pixels_that_cannot_be_written_to_are_copied(pixel_format: PixelFormat) -> None:
    raw = _raw(pixel_format)
    raw.data.flags.writeable = False
    result = stamp.stamped(raw, WALL)
    assert stamp.read(_luma(raw)) is None
    assert stamp.read(_luma(result)) == Stamp.at(99, WALL)
    assert (result.sequence, result.captured_at, result.format) == (99, 5.0, pixel_format)


def test_a_view_of_an_i420_picture_is_copied_too() -> None:
    wide = np.full((540, 1280), 90, np.uint8)
    raw = RawVideo(wide[:, :640], "i420", 640, 360, 99, 5.0)
    assert stamp.read(_luma(stamp.stamped(raw, WALL))) == Stamp.at(99, WALL)
    assert np.all(wide == 90)


def test_a_bottom_up_view_is_stamped_where_its_bottom_is() -> None:
    raw = _raw("bgra")
    flipped = RawVideo(raw.data[::-1], "bgra", 640, 360, 99, 5.0)
    stamp.stamped(flipped, WALL)
    assert stamp.read(_luma(flipped)) == Stamp.at(99, WALL)


def test_a_stamped_i420_picture_is_read_from_rgb_too() -> None:
    raw = _raw("i420")
    raw.data[360:] = 220
    stamp.stamped(raw, WALL)
    rgb = cv2.cvtColor(raw.data, cv2.COLOR_YUV2RGB_I420)
    for channel in range(3):
        assert stamp.read(np.ascontiguousarray(rgb[:, :, channel], np.uint8)) == Stamp.at(99, WALL)
    colours = raw.data.reshape(-1)[640 * 360 :].reshape(2, 180, 320)
    assert np.all(colours[:, :-4] == 220)


def test_the_stamp_of_an_nv12_picture_is_without_colour() -> None:
    raw = _raw("nv12")
    raw.data[360:] = 220
    stamp.stamped(raw, WALL)
    assert np.all(raw.data[360:-4] == 220)
    assert np.all(raw.data[-4:] == 128)


@pytest.mark.parametrize("mime_type", ["video/H264", "video/VP8"])
def test_the_stamp_survives_a_low_bit_rate_and_halving(mime_type: str) -> None:
    scene, encoder, decoder = (
        Scene(640, 360),
        VideoEncoder(mime_type, bitrate=300_000, frame_rate=30),
        Decoder(mime_type),
    )
    size = 0
    for number in range(20):
        raw = stamp.stamped(scene.picture(number, 100 + number / 30), WALL + number / 30)
        [chunk] = encoder.encode(raw, key_frame=False)
        size += len(chunk.data)
        [decoded] = decoder.decode(chunk.data)
        assert stamp.read(decoded) == Stamp.at(number, WALL + number / 30)
        halved = np.asarray(cv2.resize(decoded, (320, 180), interpolation=cv2.INTER_LINEAR), np.uint8)
        assert stamp.read(halved) == Stamp.at(number, WALL + number / 30)
    assert size * 8 < 300_000
