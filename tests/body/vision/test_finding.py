"""Pictures of any format, the offline finder, and how motion is measured."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.vision.box import Box, Face
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.flow import motions
from openrois_body.vision.patterns import PatternRecognizer
from openrois_body.vision.view import View
from openrois_streaming.source.source import PixelFormat, RawVideo

from tests.support.people import Sitter, nodding, picture, write_y4m

pytestmark = pytest.mark.extra(name="body")

COLLINS = Sitter("collins")


def shown(*sitters: Sitter, width: int = 640, height: int = 360, pixels: PixelFormat = "bgr24") -> View:
    data = picture(sitters, width, height)
    if pixels == "bgra":
        data = np.dstack([data, np.full(data.shape[:2], 255, np.uint8)])
    elif pixels == "i420":
        data = np.asarray(cv2.cvtColor(data, cv2.COLOR_BGR2YUV_I420), np.uint8)
    return View(RawVideo(data, pixels, width, height, 0, 5.0))


@pytest.mark.parametrize("pixels", ["bgr24", "bgra", "i420"])
@pytest.mark.parametrize(("width", "height"), [(640, 360), (360, 640), (160, 120), (1280, 720)])
def test_a_face_is_found_where_it_is_in_pictures_of_any_kind(pixels: PixelFormat, width: int, height: int) -> None:
    size = 0.2 if width > height else 0.4
    (face,) = CascadeFinder().find(shown(replace(COLLINS, size=size), width=width, height=height, pixels=pixels), [])
    assert face.box.centre == pytest.approx((0.5, 0.4), abs=0.03)
    assert face.box.width == pytest.approx(size, rel=0.15 if height > 120 else 0.25)


@pytest.mark.parametrize("size", [(2, 2), (1920, 40), (4, 300)])
def test_pictures_that_can_hardly_be_are_looked_at_all_the_same(size: tuple[int, int]) -> None:
    view = View(RawVideo(np.zeros((size[1], size[0], 3), np.uint8), "bgr24", *size, 0, 0.0))
    assert CascadeFinder().find(view, [Face(Box(0.4, 0.4, 0.2, 0.2))]) == []
    assert motions(view.grey, view.grey, [Face(Box(0.4, 0.4, 0.2, 0.2)), Face(Box(-3, 5, 1, 1))]) == [None, None]


def test_a_known_face_is_found_again_also_where_it_leans_more_than_a_new_one_may() -> None:
    view, upright = shown(replace(COLLINS, lean=28.0)), shown(COLLINS)
    (face,) = CascadeFinder().find(upright, [])
    finder = CascadeFinder()
    assert finder.find(view, []) == []
    (motion,) = motions(upright.grey, shown(replace(COLLINS, lean=14.0)).grey, [face])
    assert motion is not None
    (further,) = motions(shown(replace(COLLINS, lean=14.0)).grey, view.grey, [face.moved(motion)])
    assert further is not None
    leaning = face.moved(motion).moved(further)
    assert math.degrees(leaning.roll) == pytest.approx(28.0, abs=3.0)
    (found,) = finder.find(view, [leaning])
    assert found.box.overlap(leaning.box) > 0.7


@cache
def small() -> View:
    return shown(COLLINS, width=160, height=120)


SHARES = st.floats(-2, 2)


@settings(max_examples=40, deadline=None)
@given(known=st.builds(Face, st.builds(Box, SHARES, SHARES, st.floats(0, 3), st.floats(0, 3)), st.floats(-9, 9)))
def test_wherever_a_face_is_said_to_be_it_can_be_looked_for(known: Face) -> None:
    view = small()
    CascadeFinder().find(view, [known])
    (motion,) = motions(view.grey, view.grey, [known])
    assert motion is None or motion == pytest.approx((0, 0, 1, 0), abs=0.01)


def test_motion_is_measured_to_a_hundredth_of_a_face() -> None:
    before, after = shown(COLLINS), shown(replace(COLLINS, turn=0.1, bow=-0.05))
    (face,) = CascadeFinder().find(before, [])
    (motion,) = motions(before.grey, after.grey, [face])
    assert motion is not None
    assert motion.x / face.box.width == pytest.approx(0.1, abs=0.015)
    assert motion.y / face.box.height == pytest.approx(-0.05, abs=0.015)
    assert (motion.scale, motion.roll) == pytest.approx((1.0, 0.0), abs=0.02)


def test_face_without_texture_or_out_of_the_picture_has_no_motion() -> None:
    blank = np.full((100, 100), 90, np.uint8)
    noise = np.random.default_rng(3).integers(0, 255, (100, 100)).astype(np.uint8)
    face = Face(Box(0.2, 0.2, 0.6, 0.6))
    assert motions(blank, blank, [face]) == [None]
    assert motions(noise, np.random.default_rng(4).integers(0, 255, (100, 100)).astype(np.uint8), [face]) == [None]


def test_a_face_that_is_too_small_is_not_compared() -> None:
    assert PatternRecognizer().likeness(shown(COLLINS), Face(Box(0.4, 0.3, 0.06, 0.1))) is None


def test_the_offline_backends_work_here() -> None:
    assert CascadeFinder().available() == PatternRecognizer().available() == (True, "")


def test_without_cascades_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(cv2, "CascadeClassifier")
    works, reason = CascadeFinder().available()
    assert not works
    assert "opencv-python-headless below 5" in reason


def test_a_scene_as_a_file_for_the_fake_camera_of_a_browser(tmp_path: Path) -> None:
    write_y4m(tmp_path / "nod.y4m", nodding(COLLINS), 0.3, width=320, height=180)
    with av.open(tmp_path / "nod.y4m") as file:
        pictures = [np.asarray(frame.to_ndarray(format="bgr24"), np.uint8) for frame in file.decode(video=0)]
    assert len(pictures) == 3
    (face,) = CascadeFinder().find(View(RawVideo(pictures[0], "bgr24", 320, 180, 0, 0.0)), [])
    assert face.box.centre == pytest.approx((0.5, 0.4), abs=0.04)
