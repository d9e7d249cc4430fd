"""What `openrois avatar` says of itself: it is ready when its gateway has taken it in, and no sooner."""

import asyncio
import logging
import socket
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from openrois_avatar import command
from openrois_avatar.options.settings import AvatarSettings

from openrois.adapter import serve
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.components import Lamp
from tests.support.demo import free_port

pytestmark = pytest.mark.extra(name="demo")

LACKING = {"status": "not ready", "lacking": ["the gateway: it has not accepted this adapter"]}


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    """Stand in for systemd."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.setblocking(False)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        yield listening


class Adapter:
    """The adapter that is tried, and the gateway's port that it dials."""

    def __init__(self) -> None:
        self.port, self._figures = free_port(), free_port()
        self.settings = AvatarSettings(
            (f"ws://127.0.0.1:{self.port}/adapter",), engine="synthetic", metrics=("127.0.0.1", self._figures)
        )

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        serving = asyncio.ensure_future(command._serve(self.settings))
        try:
            await self.until("healthz", (200, {"status": "ok"}))
            yield
        finally:
            serving.cancel()
            await asyncio.wait({serving})

    async def asked(self, path: str) -> tuple[int, Any]:
        async with aiohttp.ClientSession() as http, http.get(f"http://127.0.0.1:{self._figures}/{path}") as answer:
            return answer.status, await answer.json()

    async def until(self, path: str, answer: tuple[int, Any]) -> None:
        async with asyncio.timeout(60):
            while True:
                try:
                    if await self.asked(path) == answer:
                        return
                except OSError:
                    pass
                await asyncio.sleep(0.05)


def heard(manager: socket.socket) -> list[str]:
    told = []
    while True:
        try:
            told.append(manager.recv(1000).decode())
        except BlockingIOError:
            return told


async def test_adapter_is_ready_when_its_gateway_has_accepted_it(
    capsys: pytest.CaptureFixture[str], manager: socket.socket
) -> None:
    adapter = Adapter()
    async with adapter.running():
        assert await adapter.asked("readyz") == (503, LACKING)
        assert (capsys.readouterr().out, heard(manager)) == ("", [])
        async with run_gateway(GatewaySettings(port=adapter.port)) as gateway:
            await adapter.until("readyz", (200, {"status": "ready"}))
            assert "avatar" in gateway.engine.directory.profile.engine_ids()
            assert capsys.readouterr().out == "ready avatar\n"
            assert heard(manager) == ["READY=1", "STATUS=behind its gateway"]
        await adapter.until("readyz", (503, LACKING))
        async with run_gateway(GatewaySettings(port=adapter.port)):
            await adapter.until("readyz", (200, {"status": "ready"}))
        await adapter.until("readyz", (503, LACKING))
        assert "READY=1" not in heard(manager)
    assert capsys.readouterr().out == ""
    assert heard(manager)[-1:] == ["STOPPING=1"]


async def test_adapter_that_its_gateway_refuses_is_not_ready(
    capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    adapter, refused = Adapter(), asyncio.Event()
    caplog.set_level(logging.INFO)
    listening = logging.Handler()
    listening.emit = lambda record: refused.set() if "refuses this adapter" in record.getMessage() else None  # type: ignore[method-assign]
    logging.getLogger("openrois.adapter.dialer").addHandler(listening)
    attached = asyncio.Event()
    async with (
        asyncio.timeout(60),
        run_gateway(GatewaySettings(port=adapter.port)) as gateway,
        serve(Lamp("lamp"), engine_id="avatar", gateway=adapter.settings.gateways),
    ):
        gateway.engine.on_change(attached.set)
        if "avatar" not in gateway.engine.directory.profile.engine_ids():
            await attached.wait()
        async with adapter.running():
            await refused.wait()
            assert await adapter.asked("readyz") == (503, LACKING)
    logging.getLogger("openrois.adapter.dialer").removeHandler(listening)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("token", [None, b"", b"two words"])
def test_a_token_that_cannot_be_used_ends_the_command(
    token: bytes | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "token"
    if token is not None:
        path.write_bytes(token)
    assert command.main(["--engine", "synthetic", "--token-file", str(path)]) == 1
    said = capsys.readouterr()
    assert (said.out, said.err.startswith("openrois avatar: "), str(path) in said.err) == ("", True, True)
