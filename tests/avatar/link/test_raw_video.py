import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_avatar.link.protocol import PixelFormat, Video
from openrois_avatar.link.raw_video import raw_video

WIDTH, HEIGHT = 6, 4
RANDOM = np.random.default_rng(5)
BGRA = RANDOM.integers(0, 256, (HEIGHT, WIDTH, 4), np.uint8)
PLANES = [
    RANDOM.integers(0, 256, size, np.uint8)
    for size in ((HEIGHT, WIDTH), (HEIGHT // 2, WIDTH // 2), (HEIGHT // 2, WIDTH // 2))
]
I420 = np.concatenate([plane.reshape(-1) for plane in PLANES]).reshape(HEIGHT * 3 // 2, WIDTH)


def padded(rows: NDArray[np.uint8], stride: int, bottom_up: bool) -> bytes:
    """Rows as an engine may lay them out: upside down, and each with garbage behind it."""
    flat = rows.reshape(rows.shape[0], -1)[:: -1 if bottom_up else 1]
    return np.pad(flat, ((0, 0), (0, stride - flat.shape[1])), constant_values=77).tobytes()


def interleaved(planes: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    return np.stack(planes, axis=-1).reshape(HEIGHT // 2, WIDTH)


@pytest.mark.parametrize("bottom_up", [False, True])
@pytest.mark.parametrize("stride", [WIDTH * 4, WIDTH * 4 + 8])
def test_bgra_is_upright_and_never_copied(stride: int, bottom_up: bool) -> None:
    pixels = padded(BGRA, stride, bottom_up)
    picture = raw_video(Video(1, 0, WIDTH, HEIGHT, stride, PixelFormat.BGRA, pixels, bottom_up), 9, 2.5)
    np.testing.assert_array_equal(picture.data, BGRA)
    assert (picture.format, picture.width, picture.height) == ("bgra", WIDTH, HEIGHT)
    assert (picture.sequence, picture.captured_at) == (9, 2.5)
    assert np.shares_memory(picture.data, np.frombuffer(pixels, np.uint8))


@pytest.mark.parametrize("bottom_up", [False, True])
@pytest.mark.parametrize("stride", [WIDTH, WIDTH + 4])
def test_i420_is_upright_and_without_padding(stride: int, bottom_up: bool) -> None:
    strides = (stride, stride // 2, stride // 2)
    pixels = b"".join(padded(plane, size, bottom_up) for plane, size in zip(PLANES, strides, strict=True))
    picture = raw_video(Video(1, 0, WIDTH, HEIGHT, stride, PixelFormat.I420, pixels, bottom_up), 0, 0)
    np.testing.assert_array_equal(picture.data, I420)
    assert picture.format == "i420"
    copied = not np.shares_memory(picture.data, np.frombuffer(pixels, np.uint8))
    assert copied is (bottom_up or stride != WIDTH)


@pytest.mark.parametrize("bottom_up", [False, True])
@pytest.mark.parametrize("stride", [WIDTH, WIDTH + 4])
def test_nv12_becomes_i420(stride: int, bottom_up: bool) -> None:
    pixels = padded(PLANES[0], stride, bottom_up) + padded(interleaved(PLANES[1:]), stride, bottom_up)
    picture = raw_video(Video(1, 0, WIDTH, HEIGHT, stride, PixelFormat.NV12, pixels, bottom_up), 0, 0)
    np.testing.assert_array_equal(picture.data, I420)
    assert picture.format == "i420"


def test_nv12_that_can_be_written_to_becomes_i420_where_it_is() -> None:
    pixels = bytearray(PLANES[0].tobytes() + interleaved(PLANES[1:]).tobytes())
    picture = raw_video(Video(1, 0, WIDTH, HEIGHT, WIDTH, PixelFormat.NV12, pixels), 0, 0)
    np.testing.assert_array_equal(picture.data, I420)
    assert np.shares_memory(picture.data, np.frombuffer(pixels, np.uint8))


@pytest.mark.parametrize("pixel_format", PixelFormat)
def test_lent_pixels_are_copied_into_the_given_memory(pixel_format: PixelFormat) -> None:
    stride = WIDTH * (4 if pixel_format is PixelFormat.BGRA else 1)
    colours = interleaved(PLANES[1:]).tobytes() if pixel_format is PixelFormat.NV12 else I420[HEIGHT:].tobytes()
    pixels = bytearray(BGRA.tobytes() if pixel_format is PixelFormat.BGRA else PLANES[0].tobytes() + colours)
    before, room = bytes(pixels), np.zeros(4 * WIDTH * HEIGHT, np.uint8)
    video = Video(1, 0, WIDTH, HEIGHT, stride, pixel_format, pixels)
    picture = raw_video(video, 0, 0, lambda size: room[:size], lent=True)
    np.testing.assert_array_equal(picture.data, BGRA if pixel_format is PixelFormat.BGRA else I420)
    assert np.shares_memory(picture.data, room)
    assert pixels == before
