"""Files are read again when they change, or on demand."""

import asyncio
import logging
from pathlib import Path

import pytest

from openrois.gateway.reloading import Reloader


def test_what_has_changed_is_read_again(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    one.write_text("1")
    read: list[str] = []
    reloader = Reloader()
    reloader.add((one, other), lambda: read.append("both"), "both")
    reloader.add((other,), lambda: read.append("other"), "the other")
    reloader.reload_changed()
    assert read == []
    one.write_text("11")
    reloader.reload_changed()
    reloader.reload_changed()
    assert read == ["both"]
    other.write_text("2")
    reloader.reload_changed()
    assert read == ["both", "both", "other"]
    other.unlink()
    reloader.reload_changed()
    reloader.reload_changed(at_all=True)
    assert read[3:] == ["both", "other", "both", "other"]


def test_what_cannot_be_used_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    def reload() -> None:
        raise ValueError("it is nonsense")

    reloader = Reloader()
    reloader.add((tmp_path / "x",), reload, "the keys")
    with caplog.at_level(logging.ERROR):
        reloader.reload_changed(at_all=True)
    assert "the keys: the previous content stays in use: it is nonsense" in caplog.text
    assert reloader.failures == 1


@pytest.mark.parametrize("error", [FileNotFoundError("it went while it was read"), RecursionError(), KeyError("x")])
def test_whatever_goes_wrong_the_others_are_read(error: Exception, tmp_path: Path) -> None:
    """A revoked token would be accepted for ever."""

    def reload() -> None:
        raise error

    read: list[str] = []
    reloader = Reloader()
    reloader.add((tmp_path / "x",), reload, "the keys")
    reloader.add((tmp_path / "y",), lambda: read.append("y"), "the list of revocations")
    reloader.reload_changed(at_all=True)
    assert (reloader.failures, read) == (1, ["y"])


async def test_it_looks_again_and_again(tmp_path: Path) -> None:
    looked = asyncio.Event()
    path = tmp_path / "x"
    turns = 0

    async def sleep(_seconds: float) -> None:
        nonlocal turns
        turns += 1
        path.write_text("x" * turns)
        await asyncio.sleep(0)

    reloader = Reloader(sleep)
    reloader.add((path,), looked.set, "x")
    running = asyncio.ensure_future(reloader.run())
    await looked.wait()
    running.cancel()
