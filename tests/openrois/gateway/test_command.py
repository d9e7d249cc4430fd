"""`openrois gateway`: what it prints, how it ends."""

import asyncio
import os
import signal
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from openrois.gateway import command
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings

pytestmark = pytest.mark.extra(name="gateway")


@pytest.fixture(autouse=True)
def _quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "set_up_logging", lambda **_options: None)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_it_says_where_it_listens_and_ends_when_it_is_told(
    name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    @asynccontextmanager
    async def run_and_be_told(settings: GatewaySettings) -> AsyncIterator[Gateway]:
        async with run_gateway(settings) as gateway:
            os.kill(os.getpid(), signal.Signals[name])
            yield gateway

    monkeypatch.setattr(command, "run_gateway", run_and_be_told)
    assert command.main(["--port", "0", "--ice-server", "stun:stun.example.org"]) == 0
    shown = capfd.readouterr()
    assert shown.out.startswith("listening http://127.0.0.1:")
    assert shown.err == ""


def test_a_second_sigterm_stops_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[None] = []

    async def drain_for_ever() -> None:
        started.append(None)
        os.kill(os.getpid(), signal.SIGTERM)
        await asyncio.Event().wait()

    @asynccontextmanager
    async def run_and_be_told(settings: GatewaySettings) -> AsyncIterator[Gateway]:
        async with run_gateway(settings) as gateway:
            os.kill(os.getpid(), signal.SIGTERM)
            yield replace(gateway, drain=drain_for_ever)

    monkeypatch.setattr(command, "run_gateway", run_and_be_told)
    assert command.main(["--port", "0"]) == 0
    assert started == [None]


@pytest.mark.parametrize("seconds", ["-1", "nan", "3601"])
def test_a_time_to_drain_that_is_none(seconds: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command.main(["--drain", seconds])
    assert "drain" in capfd.readouterr().err


def test_a_journal_that_cannot_be_used_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "diary").write_text("dear diary\n")
    assert command.main(["--port", "0", "--journal", str(tmp_path / "diary")]) == 1
    shown = capfd.readouterr()
    assert shown.err.startswith("openrois gateway: ")
    assert shown.err.endswith("diary is no journal of a gateway; name another file, or move it away\n")


def test_a_file_whose_folder_is_not_there_is_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "nowhere" / "trail"
    assert command.main(["--port", "0", "--audit-file", str(file)]) == 1
    said = f"openrois gateway: {file} cannot be written: there is no folder {file.parent}\n"
    assert capfd.readouterr() == ("", said)


def test_the_secret_of_a_turn_server_is_read_from_a_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    told: list[GatewaySettings] = []

    async def take(settings: GatewaySettings) -> None:
        told.append(settings)

    monkeypatch.setattr(command, "_run", take)
    file = tmp_path / "secret"
    file.write_text("correct horse battery\n")
    file.chmod(0o644)
    turn = ["--turn", "turn:t", "--turn-secret-file", str(file), "--turn-ttl", "120"]
    assert command.main(turn) == 0
    assert (told[0].turn, told[0].turn_secret, told[0].turn_ttl) == (("turn:t",), "correct horse battery", 120)
    assert "can be read by others" in caplog.text
    assert "correct horse" not in caplog.text
    caplog.clear()
    file.chmod(0o600)
    assert command.main(turn) == 0
    assert caplog.text == ""


@pytest.mark.parametrize("content", [None, b"\xff\xfe" * 20, b"short", b""])
def test_a_secret_that_cannot_be_used_is_said(
    content: bytes | None, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "secret"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(SystemExit):
        command.main(["--turn", "turn:t", "--turn-secret-file", str(file)])
    assert "secret" in capfd.readouterr().err.splitlines()[-1]


def test_a_taken_port_is_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert command.main(["--port", str(port)]) == 1
    shown = capfd.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert shown.err.startswith(f"openrois gateway: 127.0.0.1:{port} is taken; ")


def test_a_taken_port_for_the_figures_is_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert command.main(["--port", "0", "--metrics", str(port)]) == 1
    said = f"openrois gateway: metrics cannot be served at 127.0.0.1:{port}: the port is taken\n"
    assert capfd.readouterr().err == said


@pytest.mark.parametrize(
    "arguments",
    [["--host", "0.0.0.0"], ["--port", "70000"], ["--port", "x"], ["--engine-id", "a/b"], ["--ice-server", "x"], ["x"]],
)
def test_wrong_usage_ends_with_2(arguments: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        command.main(arguments)
    assert raised.value.code == 2
    assert "openrois gateway: " in capfd.readouterr().err
