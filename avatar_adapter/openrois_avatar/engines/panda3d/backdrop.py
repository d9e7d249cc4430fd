"""What stands still behind the figure: drawn once, and laid under pictures of the figure alone."""

import cv2
import numpy as np

from openrois_avatar.engines.settings import Pixels


class Backdrop:
    """A picture of the room without the figure, BGRA."""

    def __init__(self, pixels: Pixels) -> None:
        self._pixels = pixels.copy()
        self._room = np.empty_like(self._pixels)
        self._uncovered = np.empty(pixels.shape[:2], np.uint8)

    def lay_under(self, figure: Pixels, columns: slice, picture: Pixels) -> None:
        """Fill `picture` with the backdrop and, in these columns, with a figure on nothing before it.

        `figure` is BGRA, and where it covers a share of a pixel all four are that share of it. Its array is used.
        """
        uncovered, room = self._uncovered[:, columns], self._room[:, columns]
        cv2.bitwise_not(cv2.extractChannel(figure, 3, dst=uncovered), dst=uncovered)
        cv2.cvtColor(uncovered, cv2.COLOR_GRAY2BGRA, dst=room)
        cv2.multiply(self._pixels[:, columns], room, dst=room, scale=1 / 255)
        cv2.add(figure, room, dst=picture[:, columns])

    def fill(self, picture: Pixels) -> None:
        """Let a picture show nothing else."""
        np.copyto(picture, self._pixels)
