"""Files are read again when they change, or when somebody says so."""

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
    reloader.look()
    assert read == []
    one.write_text("11")
    reloader.look()
    reloader.look()
    assert read == ["both"]
    other.write_text("2")
    reloader.look()
    assert read == ["both", "both", "other"]
    other.unlink()
    reloader.look()
    reloader.look(at_all=True)
    assert read[3:] == ["both", "other", "both", "other"]


def test_what_cannot_be_used_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    def reload() -> None:
        raise ValueError("it is nonsense")

    reloader = Reloader()
    reloader.add((tmp_path / "x",), reload, "the keys")
    with caplog.at_level(logging.ERROR):
        reloader.look(at_all=True)
    assert "the keys: what was read before holds on: it is nonsense" in caplog.text
    assert reloader.failures == 1


@pytest.mark.parametrize("error", [FileNotFoundError("it went while it was read"), RecursionError(), KeyError("x")])
def test_whatever_goes_wrong_the_others_are_read(error: Exception, tmp_path: Path) -> None:
    """Who is revoked would be let in for ever."""

    def reload() -> None:
        raise error

    read: list[str] = []
    reloader = Reloader()
    reloader.add((tmp_path / "x",), reload, "the keys")
    reloader.add((tmp_path / "y",), lambda: read.append("y"), "the list of revocations")
    reloader.look(at_all=True)
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
