"""Whether a gateway is ready, truthfully; and why not, to its owner alone."""

import asyncio
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import aiohttp
import pytest

import openrois.gateway
from openrois.gateway.server import Gateway
from openrois.observability.health import Readiness
from tests.support import deployment

pytestmark = pytest.mark.extra(name="gateway")

TOKEN = "s" * 16


async def asked(gateway: Gateway, path: str, **headers: str) -> tuple[int, dict[str, Any]]:
    async with aiohttp.ClientSession() as http, http.get(gateway.url + path, headers=headers) as answer:
        return answer.status, await answer.json()


def test_what_is_lacking() -> None:
    readiness = Readiness()
    assert readiness.lacking() == []
    doors = {"front": True, "back": False}
    for name in doors:
        readiness.require(name, partial(doors.__getitem__, name))
    assert readiness.lacking() == ["back"]
    doors["back"] = True
    assert readiness.lacking() == []


async def test_a_gateway_that_is_full_is_not_ready() -> None:
    async with deployment.gateway(metrics_token=TOKEN, most_applications=1) as gateway:
        assert await asked(gateway, "readyz") == (200, {"status": "ready"})
        async with deployment.application(gateway) as app:
            await app.ask("rois.system.connect")
            lacking = {"status": "not ready", "lacking": ["room for connections"]}
            silent = {"status": "not ready"}
            assert await asked(gateway, "readyz") == (503, lacking)
            assert await asked(gateway, "readyz", **{"X-Forwarded-For": "203.0.113.5"}) == (503, silent)
            passed_on = {"Forwarded": "for=203.0.113.5", "Authorization": f"Bearer {TOKEN}"}
            assert await asked(gateway, "readyz", **passed_on) == (503, lacking)
            passed_on["Authorization"] = "Bearer " + "t" * 16
            assert await asked(gateway, "readyz", **passed_on) == (503, silent)
            url = urlsplit(gateway.url)
            reader, writer = await asyncio.open_connection(url.hostname, url.port)
            writer.write(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\nVia: x\r\nConnection: close\r\n")
            writer.write(b"Authorization: Bearer \xff\r\n\r\n")
            told = await reader.read()
            writer.close()
            assert told.startswith(b"HTTP/1.1 503 ")
            assert b"lacking" not in told
            assert await asked(gateway, "healthz") == (200, {"status": "ok"})


async def test_a_gateway_without_keys_asks_for_them(tmp_path: Path) -> None:
    keys = tmp_path / "keys.json"
    async with deployment.gateway(auth_jwks_file=keys) as gateway:
        assert await asked(gateway, "readyz") == (503, {"status": "not ready", "lacking": ["keys for tokens"]})


def test_the_table_for_operators_lists_what_may_lack() -> None:
    page = (Path(__file__).parents[3] / "docs" / "how-to" / "operating.md").read_text(encoding="utf-8")
    table = page.partition("| `lacking` |")[2].partition("\n\n")[0]
    listed = {line.split("`")[1] for line in table.splitlines() if line.startswith("| `")}
    sources = [path.read_text(encoding="utf-8") for path in Path(openrois.gateway.__path__[0]).glob("*.py")]
    required = {part.partition('"')[0] for text in sources for part in text.split('readiness.require("')[1:]}
    assert listed == required
