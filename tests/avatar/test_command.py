"""`openrois avatar` as a command: it stops when it is told to, whatever it is doing."""

import asyncio
import os
import signal
import socket
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from openrois_avatar import command
from openrois_avatar.options.settings import AvatarSettings


@pytest.fixture(autouse=True)
def _as_before(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    interval = sys.getswitchinterval()
    monkeypatch.setattr(command, "set_up_logging", lambda **_options: None)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.parametrize("name", [signal.SIGINT, signal.SIGTERM])
def test_adapter_can_be_stopped_while_its_game_engine_starts(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: signal.Signals
) -> None:
    cleaned: list[str] = []

    @asynccontextmanager
    async def slow_to_start(_settings: AvatarSettings) -> AsyncIterator[None]:
        try:
            os.kill(os.getpid(), name)
            async with asyncio.timeout(60):
                await asyncio.Event().wait()
            yield
        finally:
            # An impatient person presses again: what is being ended is ended all the same.
            os.kill(os.getpid(), name)
            for _ in range(20):
                await asyncio.sleep(0)
            cleaned.append("up")

    monkeypatch.setattr(command, "run_avatar", slow_to_start)
    assert command.main(["--engine", "puppet"]) == 0
    assert cleaned == ["up"]
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    "arguments",
    [
        ("--link", "8766"),
        ("--link-secret-file", "no/such/file"),
        ("--pixel-streaming", "8888"),
        ("--max-viewer-bitrate", "fast"),
        ("--max-viewer-bitrate", "5"),
        ("--max-encoders", "0"),
        ("--max-encoders", "many"),
        ("--pixel-streaming", "ws://[::1]", "--engine", "unreal"),
        ("--stamp",),
        ("--component", "nowhere_at_all:Lamp"),
        ("--voice", "alto"),
        ("--voice openai", "--engine", "synthetic", "--voice-url", "https://h.example"),
        ("--ears-url", "http://h.example"),
        ("--ears openai", "--engine", "unreal", "--ears-url", "https://h.example"),
    ],
)
def test_the_command_says_what_is_wrong(arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main(["--engine", "external", *(each for each in arguments if " " not in each)])
    assert arguments[0] in capsys.readouterr().err


def test_a_component_that_cannot_be_made_ends_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "silent_component.py").write_text(
        "from openrois.adapter import Component\n"
        "class Silent(Component, authority='Example', function='sensing'):\n"
        "    def __init__(self, body):\n"
        "        raise OSError(f'{body.engine_id} has no sensor')\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    assert command.main(["--engine", "synthetic", "--component", "silent_component:Silent"]) == 1
    said = "openrois avatar: --component silent_component:Silent cannot be made: avatar has no sensor\n"
    assert capsys.readouterr().err.endswith(said)


def test_an_address_that_cannot_be_listened_on_ends_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--engine", "external", "--link", "tcp:192.0.2.1:1"]) == 1
    assert "is no loopback address" in capsys.readouterr().err


def test_a_port_of_a_facade_that_is_taken_ends_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        facade = f"127.0.0.1:{taken.getsockname()[1]}"
        assert command.main(["--engine", "unreal", "--facade", facade, "--link", "tcp:127.0.0.1:0"]) == 1
    assert f"cannot listen on {facade}" in capsys.readouterr().err
