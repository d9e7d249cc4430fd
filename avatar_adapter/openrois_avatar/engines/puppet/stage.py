"""The stage: the figure is drawn at twice the size in front of a backdrop, and made smaller."""

from typing import Final

import cv2
import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.puppet import arms
from openrois_avatar.engines.puppet.body import Body
from openrois_avatar.engines.puppet.canvas import Canvas, colour, shared
from openrois_avatar.engines.puppet.face import Face, draw_ear
from openrois_avatar.engines.puppet.hair import Hair
from openrois_avatar.engines.puppet.view import Lens, View
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.settings import Picture, Pixels

_OVERSAMPLING: Final = 2
"""The drawing is so many times larger than the picture, which smooths its edges."""


class Stage:
    """Draws the figure."""

    def __init__(self, picture: Picture) -> None:
        cv2.setNumThreads(1)
        self._size = (picture.width, picture.height)
        self._lens = Lens(picture.width * _OVERSAMPLING, picture.height * _OVERSAMPLING)
        self._backdrop = _backdrop(self._lens)
        self._large = self._backdrop.copy()
        self._small = np.empty((picture.height, picture.width, 4), np.uint8)
        self._canvas = Canvas(shared(self._large))
        self._body, self._face, self._hair = Body(self._lens.scale), Face(self._lens.scale), Hair()

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """The figure in this pose as BGRA, (height, width, 4), top row first; the next call uses the same array."""
        np.copyto(self._large, self._backdrop)
        canvas, view = self._canvas, View.of(pose, self._lens)
        self._hair.draw_behind(canvas, view)
        arms.draw_upper(canvas, view, pose)
        self._body.draw(canvas, view, pose)
        self._face.draw(canvas, view, pose)
        self._hair.draw_before(canvas, view)
        draw_ear(canvas, view, -1, pose.head_yaw)
        arms.draw_lower(canvas, view, pose)
        cv2.resize(self._large, self._size, dst=self._small, interpolation=cv2.INTER_AREA)
        return self._small


def _backdrop(lens: Lens) -> Pixels:
    """A soft light on a wall."""
    x = (np.arange(lens.width, dtype=np.float32) - lens.width / 2) / lens.scale
    z = (lens.height / 2 - np.arange(lens.height, dtype=np.float32)) / lens.scale
    share = 1 - np.outer(np.exp(-(((z - 0.5) / 2.0) ** 2)), np.exp(-((x / 2.5) ** 2)))
    centre, edge = (np.asarray(colour(part)[::-1]) for part in (palette.BACKDROP_CENTRE, palette.BACKDROP_EDGE))
    pixels = np.full((lens.height, lens.width, 4), 255, np.uint8)
    # Noise of less than a step keeps a slow change of colour from showing bands.
    grain = np.random.default_rng(1).random(share.shape, np.float32)
    for channel in range(3):
        pixels[:, :, channel] = share * (edge[channel] - centre[channel]) + (grain + centre[channel])
    return pixels
