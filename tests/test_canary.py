"""No secret is said by any test; and a gateway that is used wrongly in every way says none either."""

import asyncio
import json
import os
import signal
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import aiohttp
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from tests.support import deployment, tokens
from tests.support.canary import CANARY, leak
from tests.support.deployment import Application

WRITTEN = ("said", "log", "audit", "journal")
FORGED = f"{CANARY}.is.no-token"


def token() -> str:
    now = time.time()
    claims = {"sub": "anna", "iat": now, "exp": now + 600, "jti": "t1", "roles": ["operator"], "scope": ["*"]}
    return tokens.forge({"alg": "HS256"}, claims)


@pytest.mark.parametrize("text", [tokens.SECRET, f"{tokens.SECRET}y", tokens.forge({"alg": "HS256"}, {"sub": "anna"})])
def test_a_leak_is_found(text: str) -> None:
    assert leak([("Captured log call", "fine"), ("Captured stderr call", f"fine\nBearer {text}\nfine")]).endswith(
        "stands in 'Captured stderr call', behind 'Bearer '"
    )
    assert leak([("Captured log call", "eyJ.x and the canary")]) == ""


@dataclass
class Running:
    """A gateway as a process, with everything switched on that writes."""

    url: str
    pid: int
    folder: Path
    metrics: str = ""


@asynccontextmanager
async def gateway(folder: Path) -> AsyncIterator[Running]:
    for name, text in (("key", tokens.SECRET), ("turn", f"{CANARY}-of-the-relay"), ("figures", f"{CANARY}-of-figures")):
        (folder / name).write_text(text)
        (folder / name).chmod(0o600)
    (folder / "gateway.toml").write_text(
        """
        [listen]
        port = 0
        [auth]
        auth_keys = ["key"]
        [streams]
        turn = ["turn:relay.example.org"]
        turn_secret_file = "turn"
        [operation]
        verbose = true
        log_format = "json"
        log_file = "log"
        audit_file = "audit"
        journal = "journal"
        metrics = "127.0.0.1:0"
        metrics_token_file = "figures"
        """
    )
    with (folder / "said").open("wb") as said:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-X", "dev", "-m", "openrois.cli", "gateway", "--config", str(folder / "gateway.toml")),
            stdout=asyncio.subprocess.PIPE,
            stderr=said,
            env=os.environ | {"PYTHONASYNCIODEBUG": "1"},
        )
        assert process.stdout is not None
        try:
            async with asyncio.timeout(30):
                url = (await process.stdout.readline()).decode().removeprefix("listening ").strip()
            yield Running(url, process.pid, folder)
        finally:
            process.send_signal(signal.SIGTERM)
            assert await process.wait() == 0


async def test_a_gateway_that_is_used_wrongly_in_every_way_says_no_secret(tmp_path: Path) -> None:
    good = token()
    async with gateway(tmp_path) as running:
        socket = running.url.replace("http", "ws")
        async with connect(socket, additional_headers={"Authorization": f"Bearer {good}"}) as opened:
            app = Application(opened)
            assert (await app.ask("rois.system.connect"))["return_code"] == "OK"
            assert (await app.ask("signaling.ice_servers"))["return_code"] == "OK"
            await app.ask("rois.command.bind", component_ref=good)
            await app.ask("rois.query.query", query_type=good, condition=f"component_ref = '{good}'")
            await app.send({"jsonrpc": "2.0", "id": good, "method": good, "params": {"token": good}})
            await app.hear()
            await app.ask("openrois.auth.refresh", token=FORGED)
            await app.send(good)
            await app.hear()
        for headers, path in (
            ({"Authorization": f"Bearer {FORGED}"}, ""),
            ({"Authorization": f"Basic {FORGED}"}, "adapter"),
            ({"Sec-WebSocket-Protocol": f"openrois.v1, openrois.bearer.{FORGED}"}, ""),
            ({"Authorization": f"Bearer {good}", "Origin": "https://evil.example.org"}, ""),
            ({}, f"?token={good}"),
            ({}, good),
        ):
            with pytest.raises(InvalidStatus):
                async with connect(socket + path, additional_headers=headers):
                    pass
        said = [await unreadable(running.url, good), await page(running.url, good)]
        told = await figures(running)
    said += [(tmp_path / name).read_bytes().decode(errors="replace") for name in WRITTEN]
    assert "openrois_gateway_connections_total" in told
    assert "rois.system.connect" in (tmp_path / "log").read_text()
    assert '"refused"' in (tmp_path / "audit").read_text()
    for name, text in zip(("answers", "answers", *WRITTEN), said, strict=True):
        assert leak([(name, text)]) == ""
        assert good not in text
    assert leak([("figures", told)]) == ""


async def unreadable(url: str, secret: str) -> str:
    """Send a request that cannot be read and return what is answered."""
    host, port = url.removeprefix("http://").rstrip("/").split(":")
    reader, writer = await asyncio.open_connection(host, int(port))
    writer.write(f"GET / HTTP/1.1\r\nHost: localhost\r\nX: \x00\r\nAuthorization: Bearer {secret}\r\n\r\n".encode())
    async with deployment.patience():
        answer = await reader.read()
    writer.close()
    return answer.decode()


async def page(url: str, secret: str) -> str:
    async with aiohttp.ClientSession() as http, http.get(f"{url}{secret}", headers={"Cookie": secret}) as answer:
        return await answer.text()


async def figures(running: Running) -> str:
    lines = [json.loads(line) for line in (running.folder / "log").read_text().splitlines()]
    (url,) = [line["message"].removeprefix("metrics: ") for line in lines if line["message"].startswith("metrics: ")]
    headers = {"Authorization": f"Bearer {CANARY}-of-figures"}
    async with aiohttp.ClientSession() as http, http.get(url, headers=headers) as answer:
        assert answer.status == 200
        return await answer.text()
