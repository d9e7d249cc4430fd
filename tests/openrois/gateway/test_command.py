"""`openrois gateway`: what it prints, how it ends."""

import os
import signal
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from openrois.gateway import command
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings


@pytest.fixture(autouse=True)
def _quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "set_up_logging", lambda *, verbose: None)


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


def test_a_taken_port_is_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert command.main(["--port", str(port)]) == 1
    shown = capfd.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert shown.err.startswith(f"openrois gateway: 127.0.0.1:{port}: ")
    assert "in use" in shown.err


@pytest.mark.parametrize(
    "arguments",
    [["--host", "0.0.0.0"], ["--port", "70000"], ["--port", "x"], ["--engine-id", "a/b"], ["--ice-server", "x"], ["x"]],
)
def test_wrong_usage_ends_with_2(arguments: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        command.main(arguments)
    assert raised.value.code == 2
    assert "openrois gateway: error: " in capfd.readouterr().err
