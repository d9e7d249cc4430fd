"""Raw media as PyAV's frames."""

import numpy as np
import pytest
from openrois_streaming.source.av_frames import picture_frame, sound_frame
from openrois_streaming.source.source import PixelFormat, RawAudio, RawVideo, picture_shape


def raw(pixel_format: PixelFormat, width: int, height: int) -> RawVideo:
    shape = picture_shape(pixel_format, width, height)
    pixels = np.random.default_rng(1).integers(16, 235, shape, np.uint8)
    return RawVideo(pixels, pixel_format, width, height, 0, 1.0)


@pytest.mark.parametrize("pixel_format", ["i420", "bgr24", "bgra"])
@pytest.mark.parametrize("size", [(160, 90), (64, 48), (6, 6)])
def test_a_frame_has_the_pixels(pixel_format: PixelFormat, size: tuple[int, int]) -> None:
    picture = raw(pixel_format, *size)
    frame = picture_frame(picture)
    assert (frame.width, frame.height) == size
    assert np.array_equal(frame.to_ndarray(), picture.data)


@pytest.mark.parametrize("channels", [1, 2])
def test_sound_keeps_its_samples(channels: int) -> None:
    samples = np.arange(480 * channels, dtype=np.int16).reshape(480, channels)
    frame = sound_frame(RawAudio(samples, 1.0))
    assert (frame.samples, frame.sample_rate, len(frame.layout.channels)) == (480, 48_000, channels)
    assert np.array_equal(frame.to_ndarray().reshape(-1, channels), samples)
