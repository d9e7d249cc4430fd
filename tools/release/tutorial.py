"""The first hour of a user, as `docs/first-hour` has it, with the product that is installed in one environment."""

import os
import shutil
import signal
import socket
import subprocess
import time
import urllib.request
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final

__all__ = ["TutorialFailed", "run_tutorial"]

_PATIENCE: Final = 120.0
"""Seconds for each step on a busy machine."""
_EXAMPLES: Final = ("lamp_adapter.py", "lamp_switch.py", "talk.py", "test_lamp.py")
_SEE_AVATAR: Final = """
import asyncio, sys
from openrois.client import Client
from openrois.client.components import Reaction, SpeechSynthesis

async def main(url: str) -> None:
    async with Client(url) as client:
        for kind in (Reaction, SpeechSynthesis):
            component = await client.find(kind, within=60)
            while await component.component_status() != "READY":
                await asyncio.sleep(0.2)
            print(component.component_ref)

asyncio.run(main(sys.argv[1]))
"""
"""Waits until the figure moves, as a reader of the page sees it: on a busy machine its first pictures take a while."""


class TutorialFailed(Exception):
    """A step did not do what the page says."""


def run_tutorial(environment: Path, examples: Path, folder: Path) -> None:
    """See the avatar, run the application on it, put the adapter behind the same gateway, and test that.

    Args:
        environment: a virtual environment with `openrois[demo]`, pytest and pytest-asyncio.
        examples: the folder with the tutorial's programs.
        folder: an empty folder, where they are run.

    Raises:
        TutorialFailed: a step did not do what the page says.
    """
    for name in _EXAMPLES:
        shutil.copy(examples / name, folder)
    (folder / "pytest.ini").write_text("[pytest]\nasyncio_mode = auto\n", encoding="utf-8")
    port = _free_port()
    url = f"ws://127.0.0.1:{port}/"
    python = environment / "bin" / "python"
    openrois = environment / "bin" / "openrois"
    with _running(folder, openrois, "demo", "--engine", "puppet", "--port", str(port)) as avatar:
        _wait_for(avatar, "ready ")
        _look_at_page(f"http://127.0.0.1:{port}/")
        _expect("avatar/", folder, python, "-c", _SEE_AVATAR, url)
        _expect("said: Hello!", folder, python, "talk.py", "Hello!", url)
        with _running(folder, python, "lamp_adapter.py", "--gateway", f"{url}adapter") as lamp:
            _wait_for(lamp, "connected to ")
            _wait_until_there(folder, openrois, "profile", "export", "--url", url, "--component", "lamp_1/lamp")
            _expect("on: True, 3.0 W", folder, python, "lamp_switch.py", url)
    _expect(" passed", folder, python, "-m", "pytest", "-q")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _outside() -> Mapping[str, str]:
    """Return the environment without what leads to a checkout's packages."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}


@contextmanager
def _running(folder: Path, *words: str | Path) -> Iterator[IO[str]]:
    """Run a program while the block runs, and yield what it says; it has to end when Ctrl-C tells it to."""
    process = subprocess.Popen(
        [str(word) for word in words],
        cwd=folder,
        env=_outside(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    try:
        yield process.stdout
    finally:
        os.killpg(process.pid, signal.SIGINT)
        try:
            process.communicate(timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise TutorialFailed(f"{words[1]} does not end after Ctrl-C") from None


def _wait_for(output: IO[str], wanted: str) -> None:
    """Read lines until one has the text; a program that ends sooner has failed."""
    said = []
    for line in output:
        said.append(line)
        if wanted in line:
            return
    raise TutorialFailed(f"{wanted!r} was expected:\n{''.join(said)}")


def _wait_until_there(folder: Path, *words: str | Path) -> None:
    """Run a program until it succeeds: the gateway asks a new adapter for its profile before it is there."""
    end = time.monotonic() + _PATIENCE
    while (done := _run(folder, *words)).returncode:
        if time.monotonic() > end:
            raise TutorialFailed(f"{' '.join(map(str, words[1:]))}:\n{done.stderr}")
        time.sleep(0.2)


def _look_at_page(url: str) -> None:
    with urllib.request.urlopen(url, timeout=_PATIENCE) as answer:
        if b"<html" not in answer.read():
            raise TutorialFailed(f"{url} is no page")


def _expect(wanted: str, folder: Path, *words: str | Path) -> None:
    """Run a program to its end; it has to succeed and say the text."""
    done = _run(folder, *words)
    if done.returncode or wanted not in done.stdout:
        raise TutorialFailed(f"{words[1]}: {wanted!r} was expected:\n{done.stdout}{done.stderr}")


def _run(folder: Path, *words: str | Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        env=_outside(),
        capture_output=True,
        text=True,
        check=False,
        timeout=_PATIENCE,
    )
