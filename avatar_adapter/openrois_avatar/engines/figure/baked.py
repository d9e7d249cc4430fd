"""Reads the baked figures: meshes with names of how they move, in the files that `python -m tools.sculpt` writes.

A file is an `.npz` archive of plain arrays, which is never unpickled. The array `pieces` is a text in JSON: a list of
objects with the fields of `Piece`, where `arrays` maps the name of an array to its key in the file; pieces that have
an array in common share its key. The other arrays are stored so that they compress to a third:

- numbers as 32-bit integers, in steps of `STEP`: a byte array whose first axis goes over the bytes of each, the least
  first; the other axes are those of the numbers, in reverse
- faces (m, 3) as 16-bit integers (3, m): each the difference from the one before, modulo 65536
"""

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.figure.mesh import Mesh

Name = Literal["avatar", "visitor", "room"]
Arrays = Mapping[str, npt.NDArray[Any]]
NAMES: Final[tuple[Name, ...]] = ("avatar", "visitor", "room")
STEP: Final = 2.0**-20
"""The step to which numbers are rounded, so that they are off by less than 0.5e-6."""
FOLDER: Final = Path(__file__).parent


class BakedError(RuntimeError):
    """A baked figure cannot be read."""


@dataclass(frozen=True)
class Piece:
    """One mesh of a baked figure.

    `motion` is how it moves, by a name that the figure knows. `side` is +1 for the avatar's left and -1 for its right;
    what never changes its shape is mirrored for -1. `finish` is a key of `shading.FINISHES`. The arrays are `faces`
    (m, 3), wound for its side, `albedo` (n, 3), `openness` (n,), `gloss` (n,), and those that its motion needs.
    """

    name: str
    space: str
    motion: str
    side: int
    finish: str
    arrays: Arrays

    def mesh(self) -> Mesh:
        """The mesh of a piece that never changes its shape."""
        of = self.arrays
        side = (self.side, 1, 1)
        return Mesh(of["vertices"] * side, of["normals"] * side, of["faces"], of["albedo"], of["openness"])


def path_of(name: Name, folder: Path = FOLDER) -> Path:
    """Return the path of the file of a baked figure."""
    return folder / f"{name}.npz"


def read(name: Name, folder: Path = FOLDER) -> list[Piece]:
    """Read the pieces of a baked figure.

    Raises:
        BakedError: the file is missing, or is not what `python -m tools.sculpt` writes.
    """
    path = path_of(name, folder)
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {key: _decoded(stored[key]) for key in stored.files}
        return [
            Piece(**{**each, "arrays": {role: arrays[key] for role, key in each["arrays"].items()}})
            for each in json.loads(str(arrays["pieces"]))
        ]
    except (OSError, EOFError, BadZipFile, zlib.error, AttributeError, KeyError, TypeError, ValueError) as error:
        raise unreadable(name, error, folder) from error


def unreadable(name: Name, reason: Exception, folder: Path = FOLDER) -> BakedError:
    """Return the error that says why a figure cannot be read, and what to do."""
    said = reason.strerror if isinstance(reason, OSError) else f"{type(reason).__name__}: {reason}"
    return BakedError(
        f"the figure in {path_of(name, folder)} cannot be read ({said}): install openrois"
        " again, or in a clone of its repository run `python -m tools.sculpt`"
    )


def _decoded(stored: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the array that an array of a file encodes."""
    if stored.dtype == np.uint8:
        whole = np.ascontiguousarray(np.moveaxis(stored, 0, -1)).view("<i4")[..., 0]
        return np.ascontiguousarray(whole.T * STEP)
    if stored.dtype == np.uint16:
        return np.ascontiguousarray(np.cumsum(stored, axis=1, dtype=np.uint16).T.astype(np.int32))
    return stored
