"""What is given as a source: what is none is refused at once, with what to give in its place."""

import re
from collections.abc import AsyncIterator, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from openrois_streaming.capture.audio import AudioSource
from openrois_streaming.capture.given import check_function, is_source, source_remedy
from openrois_streaming.capture.video import EncodedSource, VideoSource
from openrois_streaming.synthetic import ColourBars, Tone

from tests.support.streaming import FedSource, VirtualClock

CAPTURE = cv2.VideoCapture()


def numbers(first: int = 0) -> Iterator[int]:
    yield first


def numbers_of(camera: str) -> Iterator[str]:
    yield camera


async def later() -> AsyncIterator[int]:
    yield 0


class Numbers:
    """An iterator that is made anew at each opening."""

    def __iter__(self) -> "Numbers":
        return self

    def __next__(self) -> int:
        return 0


class Shop:
    """Something else that can be opened."""

    def open(self, hour: int) -> None:
        """Open at an hour."""


@pytest.mark.parametrize("given", [numbers, later, lambda: iter([]), partial(numbers_of, "porch"), Numbers, iter, dict])
def test_functions_without_arguments_are_taken(given: Any) -> None:
    check_function(given, "camera", "use another")
    assert not is_source(given)


@pytest.mark.parametrize(
    "given",
    [
        ColourBars(160, 90, clock=VirtualClock()),
        Tone(clock=VirtualClock()),
        FedSource(),
        AudioSource(lambda: iter([])),
    ],
)
def test_sources_are_known(given: Any) -> None:
    assert is_source(given)


@pytest.mark.parametrize("given", [CAPTURE, cv2.VideoCapture, Path("film"), Shop(), ColourBars, 7, "film", None])
def test_what_opens_something_else_is_no_source(given: Any) -> None:
    assert not is_source(given)


CAMERAS = "use opencv_camera, v4l2_camera or ffmpeg_input for the number, path or URL of a camera"
CAPTURED = "use opencv_camera(0), which opens and releases the capture itself"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (CAPTURE, f"a VideoCapture: {CAPTURED}"),
        (cv2.VideoCapture, f"the class VideoCapture: {CAPTURED}"),
        ("/dev/video0", f"'/dev/video0': {CAMERAS}"),
        (Path("/dev/video0"), f"PosixPath('/dev/video0'): {CAMERAS}"),
        (0, f"0: {CAMERAS}"),
        (None, "a NoneType: give a generator function"),
        ([1, 2], "a list: give a generator function"),
        (np.zeros((32, 64, 3), np.uint8), "a ndarray: give a generator function"),
        (Shop(), "a Shop: give a generator function"),
        (ColourBars, "the class ColourBars: give a generator function"),
        (numbers(), "a generator: do not call it"),
        (later(), "a async_generator: do not call it"),
        (numbers_of, "one that needs arguments: bind them, as in `lambda: pictures(camera)`"),
    ],
)
def test_what_is_no_camera_is_refused_when_its_source_is_made(given: Any, told: str) -> None:
    with pytest.raises(TypeError, match=re.escape(f"camera must be a function that returns an iterator, not {told}")):
        VideoSource(given, size=(64, 32))


@pytest.mark.parametrize("given", [CAPTURE, "/dev/video0", 0, None, numbers_of])
def test_what_is_no_microphone_and_no_encoder_is_refused_when_its_source_is_made(given: Any) -> None:
    told = "must be a function that returns an iterator, not"
    with pytest.raises(TypeError, match=f"microphone {told}"):
        AudioSource(given)
    with pytest.raises(TypeError, match=f"camera {told}"):
        EncodedSource(given, size=(64, 32))


def test_the_remedy_for_a_device_is_its_own() -> None:
    with pytest.raises(TypeError, match="'hw:0': use piped_sound for a program that writes sound, such as arecord"):
        AudioSource("hw:0")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"'film\.mp4': use piped_units for a program that writes encoded pictures"):
        EncodedSource("film.mp4", size=(64, 32))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "remedy"),
    [
        (CAPTURE, CAPTURED),
        ("/dev/video0", CAMERAS),
        (numbers, "wrap it in VideoSource, EncodedSource or AudioSource"),
    ],
)
def test_the_remedy_says_what_makes_a_source_of_it(given: Any, remedy: str) -> None:
    assert source_remedy(given) == remedy
