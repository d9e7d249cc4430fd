"""JPEG and PNG files: what they are decoded to, and what is refused before it costs memory."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_robots.adapter.image_files import MOST_PIXELS, ImageFileError, decode_image, image_size

from tests.support.image_files import JPEG, PNG, RED, resized

pytestmark = pytest.mark.extra(name="robot")


@pytest.mark.parametrize("data", [JPEG, PNG], ids=["jpeg", "png"])
def test_a_picture_is_decoded(data: bytes) -> None:
    assert image_size(data) == (64, 48)
    assert decode_image(data).shape == (48, 64, 3)
    assert np.abs(decode_image(data)[40, 40].astype(int) - RED).max() < 12
    assert decode_image(data, is_grey=True).shape == (48, 64)


def test_a_jpeg_is_read_past_what_stands_before_its_size() -> None:
    before = b"\xff\xe1\x00\x06Exif" + b"\xff\xff\xfe\x00\x04no" + b"\xff\x01"
    assert image_size(JPEG[:2] + before + JPEG[2:]) == (64, 48)


@pytest.mark.parametrize("data", [JPEG, PNG], ids=["jpeg", "png"])
@pytest.mark.parametrize("size", [(65_000, 65_000), (8193, 8192), (0, 48)])
def test_a_size_out_of_bounds_is_refused_before_anything_is_decoded(
    data: bytes, size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(cv2, "imdecode")
    with pytest.raises(ImageFileError, match=f"{size[0]}x{size[1]} is not read: it may have {MOST_PIXELS} pixels"):
        decode_image(resized(data, *size))


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "0 bytes are neither a JPEG nor a PNG"),
        (b"BM" + bytes(80), "82 bytes are neither a JPEG nor a PNG"),
        (PNG[:20], "ends before its size"),
        (JPEG[:3], "ends before its size"),
        (JPEG[:2] + b"\xff\xe0\x00\x00" + bytes(9), "has no size"),
        (JPEG[:2] + b"no marker", "has no size"),
        (PNG[:40], "64x48 with 40 bytes cannot be decoded"),
    ],
)
def test_what_is_no_picture_is_said(data: bytes, said: str) -> None:
    with pytest.raises(ImageFileError, match=said):
        decode_image(data)


def test_an_error_of_the_decoder_is_no_other_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_arguments: object) -> None:
        raise cv2.error("an assertion failed")

    monkeypatch.setattr(cv2, "imdecode", fail)
    with pytest.raises(ImageFileError, match="cannot be decoded"):
        decode_image(PNG)


@given(st.binary(max_size=60), st.sampled_from([b"", JPEG[:2], JPEG[:20], PNG[:8], PNG[:24]]))
def test_any_bytes_are_a_picture_or_refused(tail: bytes, head: bytes) -> None:
    said = ""
    try:
        pixels = decode_image(head + tail)
    except ImageFileError as error:
        said = str(error)
    assert said or pixels.size
