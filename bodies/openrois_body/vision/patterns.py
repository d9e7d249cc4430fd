"""The offline face recogniser: histograms of local binary patterns. For few persons in one light; no access control."""

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_body.vision.box import Face
from openrois_body.vision.gallery import Likeness
from openrois_body.vision.view import View, upright

__all__ = ["PatternRecognizer"]

_SIDE: Final = 96
"""Pixels of the face that is compared."""
_SMALLEST: Final = 36
"""Pixels of the smallest face in the grey picture that is compared: smaller ones look all alike."""
_CELLS: Final = 7
_NEIGHBOURS: Final = ((0, 2), (1, 1), (2, 0), (1, -1), (0, -2), (-1, -1), (-2, 0), (-1, 1))


def _uniform() -> NDArray[np.uint8]:
    """Return the class of each of the 256 patterns: a class each for at most two changes around, one for all others."""
    classes, others = [], 58
    following = iter(range(others))
    for code in range(256):
        changes = (code ^ ((code >> 1) | (code & 1) << 7)).bit_count()
        classes.append(next(following) if changes <= 2 else others)
    return np.array(classes, np.uint8)


_CLASSES: Final = _uniform()
_KINDS: Final = 59


class PatternRecognizer:
    """Distinguishes faces by their texture. The result depends on light, glasses and beard.

    `limit` was measured on the only two faces that the tests have: pictures made of one photograph, lighter, darker,
    blurred, nearer or leaning, are up to 0.70 apart, those of the two persons 0.83 and more. Other days, other light
    and other people were not measured.
    """

    limit: float = 0.75

    def available(self) -> tuple[bool, str]:
        """Return that it always works."""
        return True, ""

    def likeness(self, view: View, face: Face) -> Likeness | None:
        """Return the histogram of a face, or None where it has less than `_SMALLEST` pixels."""
        size = face.box.width * view.grey.shape[1]
        if size < _SMALLEST:
            return None
        patch, _matrix = upright(view.grey, face, _SIDE / size, _SIDE)
        return _likeness_of(patch)


def _likeness_of(patch: NDArray[np.uint8]) -> Likeness:
    """Return the vector, of length 1, of a square grey picture that a face fills."""
    # The corners of the box show hair and background.
    inner = cv2.GaussianBlur(patch, (0, 0), 1.2)[_SIDE // 16 :, _SIDE // 8 : -_SIDE // 8].astype(np.int16)
    core = inner[2:-2, 2:-2]
    codes = np.zeros(core.shape, np.uint8)
    for bit, (down, right) in enumerate(_NEIGHBOURS):
        neighbour = inner[2 + down : 2 + down + core.shape[0], 2 + right : 2 + right + core.shape[1]]
        codes |= (neighbour >= core).astype(np.uint8) << bit
    kinds = _CLASSES[codes]
    cells = [cell for row in np.array_split(kinds, _CELLS) for cell in np.array_split(row, _CELLS, axis=1)]
    counts = np.stack([np.bincount(cell.ravel(), minlength=_KINDS) / cell.size for cell in cells])
    # The distance of square roots is Hellinger's: made for histograms, and Euclidean.
    return np.sqrt(counts / _CELLS**2).astype(np.float32).ravel()
