"""The offline finder of faces: the boosted cascades that come with OpenCV before version 5."""

import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_body.vision.box import Box, Face
from openrois_body.vision.view import View, upright

__all__ = ["CascadeFinder"]

_SEARCH: Final = 1.0
"""Seconds between two searches of the whole picture; in between, only known faces are searched for."""
_SEARCH_ALONE: Final = 0.4
"""The same, while no face is known."""
_SMALLEST: Final = 22
"""Pixels of the smallest face; the cascades were trained with 20."""
_ENLARGED: Final = 64
"""Pixels to which a known face is scaled down before it is searched for again."""


class CascadeFinder:
    """Finds faces that look at the camera, upright within 20 degrees, or tilted as far as they were tracked.

    Faces from the side, behind a hand or a mask, or in strong light from one side are missed.
    """

    def __init__(self) -> None:
        self._searched_at = -math.inf

    # The slower cascade takes fewer other things for faces; where one is known, the faster one is enough.

    @cached_property
    def _anywhere(self) -> Any:
        return cv2.CascadeClassifier(str(_file("alt")))

    @cached_property
    def _again(self) -> Any:
        return cv2.CascadeClassifier(str(_file("alt2")))

    def available(self) -> tuple[bool, str]:
        """Return whether OpenCV has cascades."""
        if not hasattr(cv2, "CascadeClassifier") or not _file("alt").exists():
            return False, f"OpenCV {cv2.__version__} has no cascades; install opencv-python-headless below 5"
        return True, ""

    def find(self, view: View, known: Sequence[Face]) -> Sequence[Face]:
        """Return the faces in the picture."""
        found = [again for face in known if (again := self._look_again(view.grey, face)) is not None]
        if not 0 <= view.moment - self._searched_at < (_SEARCH if known else _SEARCH_ALONE):
            self._searched_at = view.moment
            found += [face for face in self._search(view.grey) if not any(face.box.overlap(f.box) for f in found)]
        return found

    def _search(self, grey: NDArray[np.uint8]) -> list[Face]:
        height, width = grey.shape
        boxes = self._anywhere.detectMultiScale(cv2.equalizeHist(grey), 1.15, 4, minSize=(_SMALLEST, _SMALLEST))
        return [Face(_box(x / width, y / height, w / width, h / height)) for x, y, w, h in boxes]

    def _look_again(self, grey: NDArray[np.uint8], face: Face) -> Face | None:
        """Search again where a face was, twice as wide, and set upright."""
        height, width = grey.shape
        size = face.box.width * width
        if size < _SMALLEST / 2:
            return None  # it has gone too far away
        scale = min(1.0, _ENLARGED / size)
        side = round(2 * size * scale)
        patch, matrix = upright(grey, face, scale, side)
        least, most = max(_SMALLEST - 2, round(0.7 * size * scale)), round(1.4 * size * scale)
        boxes = self._again.detectMultiScale(cv2.equalizeHist(patch), 1.1, 3, minSize=(least,) * 2, maxSize=(most,) * 2)
        if not len(boxes):
            return None
        a, b, w, h = min(boxes, key=lambda box: math.hypot(box[0] + (box[2] - side) / 2, box[1] + (box[3] - side) / 2))
        back = cv2.invertAffineTransform(matrix)
        across, down = back @ np.array([a + w / 2, b + h / 2, 1.0])
        w, h = w / scale / width, h / scale / height
        return Face(_box(across / width - w / 2, down / height - h / 2, w, h), face.roll)


def _box(*shares: float) -> Box:
    return Box(*(float(share) for share in shares))  # NumPy's numbers are no concern of others


def _file(name: str) -> Path:
    return Path(cv2.__file__).parent / "data" / f"haarcascade_frontalface_{name}.xml"
