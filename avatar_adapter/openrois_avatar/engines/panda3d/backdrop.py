"""What stands still behind the figure: drawn once, and laid under pictures of the figure alone."""

import cv2
import numpy as np

from openrois_avatar.engines.settings import Pixels


class Backdrop:
    """Some columns of a picture of the room without the figure, BGRA."""

    def __init__(self, room: Pixels, columns: slice) -> None:
        self.columns = columns
        # Arrays of their own: OpenCV is several times slower with a part of a wider one.
        self._room = np.ascontiguousarray(room[:, columns])
        self._shown = np.empty_like(self._room)
        self._uncovered = np.empty(self._room.shape[:2], np.uint8)

    def lay_under(self, figure: Pixels, picture: Pixels) -> None:
        """Fill these columns of `picture` with the room and, before it, a figure that was drawn on nothing.

        `figure` is BGRA, and where it covers a share of a pixel all four are that share of it.
        """
        cv2.bitwise_not(cv2.extractChannel(figure, 3, dst=self._uncovered), dst=self._uncovered)
        cv2.cvtColor(self._uncovered, cv2.COLOR_GRAY2BGRA, dst=self._shown)
        cv2.multiply(self._room, self._shown, dst=self._shown, scale=1 / 255)
        cv2.add(figure, self._shown, dst=picture[:, self.columns])

    def fill(self, picture: Pixels) -> None:
        """Let these columns show nothing else."""
        np.copyto(picture[:, self.columns], self._room)
