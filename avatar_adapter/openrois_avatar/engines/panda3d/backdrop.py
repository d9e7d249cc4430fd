"""What stands still behind the figure: drawn once, and laid under pictures of the figure alone."""

import cv2
import numpy as np

from openrois_avatar.engines.panda3d.view import Area
from openrois_avatar.engines.settings import Pixels


class Backdrop:
    """An area of a picture of the room without the figure, BGRA."""

    def __init__(self, room: Pixels, area: Area) -> None:
        self._area = area.pixels
        # Arrays of their own: OpenCV is several times slower with a part of a wider one.
        self._room = np.ascontiguousarray(room[self._area])
        self._shown = np.empty_like(self._room)
        self._uncovered = np.empty(self._room.shape[:2], np.uint8)

    def lay_under(self, figure: Pixels, picture: Pixels) -> None:
        """Fill this area of `picture` with the room and, before it, a figure that was drawn on nothing.

        `figure` is BGRA, and where it covers a share of a pixel all four are that share of it.
        """
        cv2.bitwise_not(cv2.extractChannel(figure, 3, dst=self._uncovered), dst=self._uncovered)
        cv2.cvtColor(self._uncovered, cv2.COLOR_GRAY2BGRA, dst=self._shown)
        cv2.multiply(self._room, self._shown, dst=self._shown, scale=1 / 255)
        cv2.add(figure, self._shown, dst=picture[self._area])

    def fill(self, picture: Pixels) -> None:
        """Let this area show nothing else."""
        np.copyto(picture[self._area], self._room)
