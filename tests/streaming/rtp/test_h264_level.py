import pytest
from openrois_streaming.rtp.h264_level import h264_level


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
