"""Who may read a file with a secret."""

import os
from pathlib import Path

import pytest

from openrois.cli.secret_files import is_exposed


@pytest.mark.parametrize(
    ("owner", "mode", "exposed"),
    [
        (1000, 0o600, False),
        (1000, 0o640, True),
        (1000, 0o604, True),
        (0, 0o600, False),
        (0, 0o640, False),
        (0, 0o440, False),
        (0, 0o644, True),
    ],
)
def test_who_may_read(owner: int, mode: int, exposed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "secret"
    path.touch()
    path.chmod(mode)
    there = list(path.stat())
    there[4] = owner
    monkeypatch.setattr(Path, "stat", lambda _path: os.stat_result(there))
    assert is_exposed(path) is exposed
