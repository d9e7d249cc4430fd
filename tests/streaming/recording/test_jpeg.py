"""Pictures as JPEG files."""

import io

import av
import numpy as np
import pytest
from openrois_streaming.recording.jpeg import jpeg_of
from openrois_streaming.source.source import RawVideo


@pytest.mark.parametrize(("width", "height"), [(320, 180), (64, 48), (46, 34)])
def test_the_picture_comes_back(width: int, height: int) -> None:
    data = np.full((height * 3 // 2, width), 128, np.uint8)
    data[:height] = np.linspace(16, 235, width, dtype=np.uint8)
    file = jpeg_of(RawVideo(data, "i420", width, height, 0, 1.0))
    assert (file[:2], file[-2:]) == (b"\xff\xd8", b"\xff\xd9")
    with av.open(io.BytesIO(file), "r", format="mjpeg") as opened:
        (picture,) = opened.decode(video=0)
    grey = picture.to_ndarray(format="rgb24")[..., 1].astype(int)
    assert grey.shape == (height, width)
    # Limited range becomes full range.
    assert np.abs(grey - np.linspace(0, 255, width)).max() <= 8
