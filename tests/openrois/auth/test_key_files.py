"""Keys in files."""

import os
import stat
from pathlib import Path

import pytest

from openrois.auth.key_files import is_exposed, make_key_files, read_key_file, read_keys, read_signing_key
from openrois.auth.keys import ALGORITHMS, MAX_KEY_FILE
from tests.support.tokens import SECRET, Keys, key_file, pem


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_new_keys(algorithm: str, tmp_path: Path) -> None:
    path = tmp_path / "key"
    files = make_key_files(path, algorithm)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert read_signing_key(path)[0] == algorithm
    (key,) = read_keys(files[-1:])
    assert key.algorithm == algorithm
    with pytest.raises(FileExistsError):
        make_key_files(path, algorithm)


def test_what_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="cannot be read: No such file"):
        read_key_file(tmp_path / "nothing")
    (tmp_path / "binary").write_bytes(b"\xff" * 40)
    with pytest.raises(ValueError, match="not plain text"):
        read_key_file(tmp_path / "binary")
    (tmp_path / "long").write_bytes(b"x" * (MAX_KEY_FILE + 1))
    with pytest.raises(ValueError, match="more than"):
        read_key_file(tmp_path / "long")


def test_a_flaw_names_the_file_and_not_what_is_in_it(tmp_path: Path) -> None:
    path = key_file(tmp_path, "canary-short")
    for read in (lambda: read_keys([path]), lambda: read_signing_key(path)):
        with pytest.raises(ValueError, match=str(path)) as refused:
            read()
        assert "canary" not in str(refused.value)


def test_a_public_key_signs_nothing(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="give the private key"):
        read_signing_key(key_file(tmp_path, pem(Keys().p256)))
    with pytest.raises(ValueError, match="key"):
        read_signing_key(key_file(tmp_path, "-----BEGIN PRIVATE KEY-----\nxx\n-----END PRIVATE KEY-----"))


def test_a_secret_that_others_can_read(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = key_file(tmp_path)
    read_keys([path])
    assert not caplog.records
    path.chmod(0o644)
    read_keys([path])
    assert "chmod 600" in caplog.text
    assert SECRET not in caplog.text


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
def test_files_readable_by_others_are_exposed(
    owner: int, mode: int, exposed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "secret"
    path.touch()
    path.chmod(mode)
    there = list(path.stat())
    there[4] = owner
    monkeypatch.setattr(Path, "stat", lambda _path: os.stat_result(there))
    assert is_exposed(path) is exposed
