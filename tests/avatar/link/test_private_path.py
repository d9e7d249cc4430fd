import os
import socket
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from openrois_avatar.link.private_path import SETTLED, private_path, remove_abandoned


@pytest.fixture(autouse=True)
def place(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def left_behind(place: Path, name: str, age: float = 2 * SETTLED) -> Path:
    """A directory as a killed adapter leaves it: with a socket without a listener."""
    directory = place / name
    directory.mkdir()
    with listening(directory):
        pass
    moment = directory.stat().st_mtime - age
    os.utime(directory, (moment, moment))
    return directory


@contextmanager
def listening(directory: Path) -> Iterator[None]:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(directory / "engine"))
        listener.listen()
        yield


def test_only_this_user_reaches_the_socket_and_nothing_stays() -> None:
    with private_path() as path:
        directory = Path(path).parent
        assert stat.S_IMODE(directory.stat().st_mode) == 0o700
        assert not Path(path).exists()
    assert not directory.exists()


def test_socket_of_a_killed_adapter_is_removed(place: Path) -> None:
    abandoned = left_behind(place, "openrois-abandoned")
    with private_path():
        assert not abandoned.exists()


def test_socket_of_an_ended_process_is_removed_at_once(place: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as gone:
        gone.wait()
    abandoned = left_behind(place, f"openrois-{gone.pid}-x", age=0)
    own = left_behind(place, f"openrois-{os.getpid()}-x", age=0)
    unlistened = place / f"openrois-{gone.pid}-y"
    unlistened.mkdir()
    used = place / f"openrois-{gone.pid}-z"
    used.mkdir()
    with listening(used):
        remove_abandoned()
        assert not abandoned.exists()
        assert all(path.exists() for path in (own, unlistened, used))


def test_socket_in_use_or_new_or_of_another_user_is_kept(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    new = left_behind(place, "openrois-new", age=0)
    other = left_behind(place, "another-program")
    (place / "openrois-file").write_text("x")
    (place / "openrois-empty").mkdir()
    os.utime(place / "openrois-empty", (1, 1))
    used = place / "openrois-used"
    used.mkdir()
    with listening(used):
        os.utime(used, (1, 1))
        with private_path():
            assert all(path.exists() for path in (new, other, used, place / "openrois-file", place / "openrois-empty"))
    foreign = left_behind(place, "openrois-foreign")
    monkeypatch.setattr(os, "getuid", lambda: foreign.stat().st_uid + 1)
    with private_path():
        assert foreign.exists()
