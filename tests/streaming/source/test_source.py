import numpy as np
import pytest
from openrois_streaming.source.source import PixelFormat, RawAudio, RawVideo, picture_shape


@pytest.mark.parametrize(
    ("pixel_format", "shape"),
    [
        ("bgra", (90, 160, 4)),
        ("bgr24", (90, 160, 3)),
        ("rgb24", (90, 160, 3)),
        ("i420", (135, 160)),
        ("nv12", (135, 160)),
    ],
)
def test_a_picture_has_the_shape_of_its_format(pixel_format: PixelFormat, shape: tuple[int, ...]) -> None:
    assert picture_shape(pixel_format, 160, 90) == shape
    raw = RawVideo(np.zeros(shape, np.uint8), pixel_format, 160, 90, sequence=7, captured_at=1.5)
    assert (raw.sequence, raw.captured_at) == (7, 1.5)


@pytest.mark.parametrize("shape", [(90, 160, 3), (90, 161, 4), (160, 90, 4), (90 * 160 * 4,)])
def test_a_picture_of_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="160x90 bgra"):
        RawVideo(np.zeros(shape, np.uint8), "bgra", 160, 90, 0, 0.0)


def test_a_picture_of_another_type_is_refused() -> None:
    with pytest.raises(ValueError, match="float32"):
        RawVideo(np.zeros((90, 160, 4), np.float32), "bgra", 160, 90, 0, 0.0)


@pytest.mark.parametrize("pixel_format", ["i420", "nv12"])
@pytest.mark.parametrize("size", [(161, 90), (160, 91)])
def test_formats_with_colour_planes_of_half_size_have_even_sizes(
    pixel_format: PixelFormat, size: tuple[int, int]
) -> None:
    with pytest.raises(ValueError, match=f"{pixel_format} needs an even"):
        picture_shape(pixel_format, *size)


@pytest.mark.parametrize("size", [(0, 90), (160, 1), (-2, 2)])
def test_a_picture_has_a_size(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="must be at least 2x2 pixels"):
        picture_shape("bgra", *size)


def test_sound_has_one_or_two_channels() -> None:
    assert RawAudio(np.zeros((960, 2), np.int16), 0.0).samples.shape == (960, 2)


@pytest.mark.parametrize("samples", [np.zeros(960, np.int16), np.zeros((960, 3), np.int16), np.zeros((960, 1))])
def test_sound_of_another_shape_or_type_is_refused(samples: np.typing.NDArray[np.int16]) -> None:
    with pytest.raises(ValueError, match="a block of sound"):
        RawAudio(samples, 0.0)
