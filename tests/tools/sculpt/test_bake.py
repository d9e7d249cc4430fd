"""What is shipped is what the generator makes; and the command that sees to it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_avatar.engines.figure.baked import NAMES, Piece, path_of, read

from tools.sculpt.__main__ import main
from tools.sculpt.bake import baked, differences
from tools.sculpt.figures import FIGURES


@pytest.fixture(scope="module")
def sculpted() -> dict[str, list[Piece]]:
    return {name: sculpt() for name, sculpt in FIGURES.items()}


@pytest.mark.parametrize("name", NAMES)
def test_the_generator_makes_the_shipped_figure(sculpted: dict[str, list[Piece]], name: Any) -> None:
    shipped = read(name)
    assert [piece.name for piece in shipped] == [piece.name for piece in sculpted[name]]
    for one, other in zip(shipped, sculpted[name], strict=True):
        assert (one.space, one.motion, one.side, one.finish) == (other.space, other.motion, other.side, other.finish)
        assert one.arrays.keys() == other.arrays.keys()
        for role, array in one.arrays.items():
            assert np.allclose(array, other.arrays[role], rtol=0, atol=1e-6), f"{one.name}: {role}"
            assert array.shape == other.arrays[role].shape


def test_the_shipped_figures_are_small() -> None:
    assert sum(path_of(name).stat().st_size for name in NAMES) < 600_000


def test_an_array_that_pieces_share_is_written_once(sculpted: dict[str, list[Piece]]) -> None:
    hand = next(piece for piece in sculpted["avatar"] if piece.name == "hand")
    assert len(baked([hand, hand])) < 1.05 * len(baked([hand]))


def test_what_differs_is_named(sculpted: dict[str, list[Piece]]) -> None:
    pieces = sculpted["room"]
    assert differences(pieces, pieces) == []
    furniture, floor = pieces
    moved = {**floor.arrays, "vertices": floor.arrays["vertices"] + 0.01}
    other = Piece(floor.name, floor.space, floor.motion, floor.side, floor.finish, moved)
    assert differences(pieces, [furniture, other]) == ["floor in room: vertices differs by 0.01"]
    assert differences(pieces, [furniture]) == ["the pieces, their motions or the shapes of their arrays differ"]


@pytest.mark.long
def test_the_command_writes_what_is_missing_or_old(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--check"], tmp_path) == 1
    assert "avatar.npz is out of date" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
    assert main([], tmp_path) == 0
    assert capsys.readouterr().out.splitlines() == ["avatar.npz", "visitor.npz", "room.npz"]
    assert main(["--check"], tmp_path) == 0
    path_of("room", tmp_path).write_bytes(b"old")
    assert main([], tmp_path) == 0
    assert capsys.readouterr().out.splitlines() == ["room.npz"]
