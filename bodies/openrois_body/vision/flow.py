"""The motion of faces from one picture to the next by optical flow, which is more exact than a finder."""

import math
from collections.abc import Sequence
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_body.vision.box import Face, Motion

__all__ = ["motions"]

_SPOTS: Final = 40
_FEWEST: Final = 8
"""Spots that have to agree on a motion."""
_ASTRAY: Final = 1.0
"""Pixels by which a spot may be missed when it is followed back."""


def motions(before: NDArray[np.uint8], after: NDArray[np.uint8], faces: Sequence[Face]) -> list[Motion | None]:
    """Return the motion of each face between two grey pictures of one size; None where it is not known."""
    return [_motion(before, after, face) for face in faces]


def _motion(before: NDArray[np.uint8], after: NDArray[np.uint8], face: Face) -> Motion | None:
    height, width = before.shape
    # The middle of the box: what is at its edges is often behind the head.
    left, top, wide, high = face.box
    columns = slice(max(0, round((left + 0.15 * wide) * width)), max(0, round((left + 0.85 * wide) * width)))
    rows = slice(max(0, round((top + 0.1 * high) * height)), max(0, round((top + 0.95 * high) * height)))
    patch = before[rows, columns]
    if min(patch.shape) < _FEWEST:
        return None
    corners: Any = cv2.goodFeaturesToTrack(np.ascontiguousarray(patch), _SPOTS, 0.01, 3)
    if corners is None:
        return None
    spots = np.asarray(corners + np.array([columns.start, rows.start]), np.float32)
    there = _followed(before, after, spots)
    back = _followed(after, before, there)
    steady = np.abs(back - spots).max(axis=(1, 2)) < _ASTRAY
    if steady.sum() < _FEWEST:
        return None
    similarity, agreeing = cv2.estimateAffinePartial2D(spots[steady], there[steady], ransacReprojThreshold=2.0)
    if similarity is None or agreeing.sum() < _FEWEST:
        return None
    middle = np.array([face.box.centre[0] * width, face.box.centre[1] * height, 1.0])
    x, y = similarity @ middle - middle[:2]
    scale, roll = math.hypot(similarity[0, 0], similarity[1, 0]), math.atan2(similarity[1, 0], similarity[0, 0])
    return Motion(x / width, y / height, scale, roll)


def _followed(before: NDArray[np.uint8], after: NDArray[np.uint8], spots: NDArray[np.float32]) -> NDArray[np.float32]:
    there, _found, _error = cv2.calcOpticalFlowPyrLK(before, after, spots, spots.copy(), winSize=(15, 15), maxLevel=3)
    return np.asarray(there, np.float32)
