"""The files of the baked figures: read without pickle, and what is said of one that cannot be read."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_avatar.engines.figure import figure
from openrois_avatar.engines.figure.baked import NAMES, BakedError, Piece, path_of, read
from openrois_avatar.engines.figure.shading import FINISHES

PIECE: dict[str, Any] = {"name": "a", "space": "head", "motion": "still", "side": 1, "finish": "skin"}
REMEDY = "install openrois again, or in a clone of its repository run `python -m tools.sculpt`"


def archive(pieces: object, **arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez(file, pieces=np.asarray(json.dumps(pieces)), **arrays)
    return file.getvalue()


def with_an_object() -> bytes:
    file = io.BytesIO()
    np.savez(file, pieces=np.asarray([{"name": "a"}], object))
    return file.getvalue()


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_figure_has_whole_pieces(name: Any) -> None:
    pieces = read(name)
    assert pieces
    for piece in pieces:
        count = len(piece.arrays["albedo"])
        assert piece.arrays["openness"].shape == piece.arrays["gloss"].shape == (count,)
        assert 0 <= piece.arrays["faces"].min() <= piece.arrays["faces"].max() < count
        assert piece.finish in FINISHES
        assert piece.side in (1, -1)


def test_numbers_and_faces_are_decoded(tmp_path: Path) -> None:
    # 1.5 is 0x180000 steps, and -2^-20 is one step below zero; faces go on from the one before, also past 65535.
    numbers = np.asarray([[0x00, 0xFF], [0x00, 0xFF], [0x18, 0xFF], [0x00, 0xFF]], np.uint8)
    faces = np.asarray([[7, 65535], [1, 2], [65535, 0]], np.uint16)
    described = {**PIECE, "arrays": {"share": "x", "faces": "y"}}
    path_of("room", tmp_path).write_bytes(archive([described], x=numbers, y=faces))
    (piece,) = read("room", tmp_path)
    assert piece.arrays["share"].tolist() == [1.5, -(2.0**-20)]
    assert piece.arrays["faces"].tolist() == [[7, 1, 65535], [6, 3, 65535]]
    assert piece.arrays["faces"].dtype == np.int32


@pytest.mark.parametrize(
    "content",
    [
        None,
        b"",
        b"version https://git-lfs.github.com/spec/v1",
        b"PK\x03\x04 cut short",
        archive({"not": "a list"}),
        archive([{**PIECE, "arrays": {"vertices": "lost"}}]),
        archive([{**PIECE, "arrays": {}, "more": 1}]),
        archive([{"name": "a"}]),
        with_an_object(),
    ],
    ids=["missing", "empty", "text", "cut", "no list", "array lost", "field unknown", "field lost", "pickled"],
)
def test_an_unreadable_file_is_named_with_the_remedy(tmp_path: Path, content: bytes | None) -> None:
    path = path_of("avatar", tmp_path)
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(BakedError) as caught:
        read("avatar", tmp_path)
    assert str(path) in str(caught.value)
    assert REMEDY in str(caught.value)


def test_a_file_cut_in_its_middle_is_unreadable(tmp_path: Path) -> None:
    whole = path_of("visitor").read_bytes()
    path_of("visitor", tmp_path).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BakedError, match="visitor"):
        read("visitor", tmp_path)


def test_a_damaged_array_is_unreadable(tmp_path: Path) -> None:
    whole = bytearray(path_of("visitor").read_bytes())
    for place in range(2000, 2040):
        whole[place] ^= 0xFF
    path_of("visitor", tmp_path).write_bytes(whole)
    with pytest.raises(BakedError, match="visitor"):
        read("visitor", tmp_path)


def test_a_motion_that_the_figure_does_not_know_makes_it_unreadable(monkeypatch: pytest.MonkeyPatch) -> None:
    common = {"albedo": np.ones((1, 3)), "openness": np.ones(1), "gloss": np.ones(1)}
    monkeypatch.setattr(figure, "read", lambda name: [Piece("a", "head", "dance", 1, "skin", common)])
    with pytest.raises(BakedError, match="dance"):
        figure.build()
