"""Writes figures as the files that engines read, and compares them with those."""

import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from openrois_avatar.engines.figure.baked import STEP, Piece

TOLERANCE: Final = 1e-6
"""How far two values of one figure may be apart: machines compute the last digits differently."""


def baked(pieces: Sequence[Piece]) -> bytes:
    """A figure as the content of its file, with every array once."""
    stored: dict[str, npt.NDArray[Any]] = {}
    keys: dict[tuple[Any, ...], str] = {}
    listed = []
    for number, piece in enumerate(pieces):
        roles = {}
        for role, array in piece.arrays.items():
            encoded = _encoded(array)
            identity = encoded.dtype.str, encoded.shape, encoded.tobytes()
            key = keys.setdefault(identity, f"{number:02} {piece.name} {role}")
            stored[key] = encoded
            roles[role] = key
        listed.append({**asdict(piece), "arrays": roles})
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, pieces=np.asarray(json.dumps(listed)), **stored)
    return file.getvalue()


def differences(one: Sequence[Piece], other: Sequence[Piece]) -> list[str]:
    """Return the differences of two figures, as lines for the output of a check."""
    if [_described(piece) for piece in one] != [_described(piece) for piece in other]:
        return ["the pieces, their motions or the shapes of their arrays differ"]
    return [
        f"{piece.name} in {piece.space}: {role} differs by {apart:.2g}"
        for piece, twin in zip(one, other, strict=True)
        for role in piece.arrays
        if (apart := float(np.abs(piece.arrays[role] - twin.arrays[role]).max())) > TOLERANCE
    ]


def _described(piece: Piece) -> dict[str, Any]:
    return {**asdict(piece), "arrays": {role: array.shape for role, array in piece.arrays.items()}}


def _encoded(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The array as a file has it, which the reader's module describes."""
    if array.dtype.kind == "i":
        return np.diff(array, axis=0, prepend=0).T.astype(np.uint16)
    whole = np.ascontiguousarray(np.round(array / STEP).astype("<i4").T)
    return np.moveaxis(whole[..., None].view(np.uint8), -1, 0)
