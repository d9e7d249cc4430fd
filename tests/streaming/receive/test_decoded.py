"""Decoded pictures as arrays."""

import numpy as np
import pytest
from openrois_streaming.receive.decoded import DecodedPicture, DecodedPictures, PixelPool
from openrois_streaming.receive.remote_time import CaptureTime
from openrois_streaming.source.av_frames import FrameFormat, picture_frame
from openrois_streaming.source.source import RawVideo


@pytest.fixture
def blue() -> DecodedPicture:
    """Blue by BT.601, limited range."""
    data = np.concatenate((np.full((16, 16), 41), np.full((4, 16), 240), np.full((4, 16), 110))).astype(np.uint8)
    return DecodedPictures()(picture_frame(RawVideo(data, "i420", 16, 16, 0, 1.0)), 7, CaptureTime(1.0, 2.0))


@pytest.mark.parametrize(("pixel_format", "place"), [("rgb24", 2), ("bgr24", 0)])
def test_colours(blue: DecodedPicture, pixel_format: FrameFormat, place: int) -> None:
    pixels = blue.pixels(pixel_format)
    assert pixels.shape == (16, 16, 3)
    expected = [0, 0, 0]
    expected[place] = 255
    assert np.abs(pixels[8, 8].astype(int) - expected).max() <= 3
    assert blue.pixels(pixel_format) is pixels, "readers share it"


def test_as_a_raw_picture(blue: DecodedPicture) -> None:
    raw = blue.raw()
    assert (raw.format, raw.width, raw.height, raw.sequence) == ("i420", 16, 16, 7)
    assert (raw.captured_at, raw.reported_at) == (1.0, 2.0)
    assert raw.data is blue.pixels("i420")


class TestPool:
    def test_an_array_is_used_again_when_it_is_not_read_any_more(self) -> None:
        pool = PixelPool()
        first = pool.array((4, 4, 3))
        address = first.ctypes.data
        second = pool.array((4, 4, 3))
        assert second.ctypes.data != address
        del first
        assert pool.array((4, 4, 3)).ctypes.data == address

    def test_a_view_keeps_its_array(self) -> None:
        pool = PixelPool()
        array = pool.array((4, 4, 3))
        view, address = array[1:, :2], array.ctypes.data
        del array
        assert pool.array((4, 4, 3)).ctypes.data != address
        del view
        assert pool.array((4, 4, 3)).ctypes.data == address

    def test_another_size_is_another_array(self) -> None:
        pool = PixelPool()
        assert pool.array((4, 4, 3)).shape == (4, 4, 3)
        assert pool.array((2, 6, 3)).shape == (2, 6, 3)

    def test_it_keeps_a_few(self) -> None:
        pool = PixelPool()
        held = [pool.array((4, 4, 3)) for _ in range(10)]
        assert len({each.ctypes.data for each in held}) == 10
