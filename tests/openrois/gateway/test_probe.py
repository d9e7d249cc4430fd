"""Asking a gateway of this machine whether it is alive."""

import asyncio
from pathlib import Path

import pytest

from openrois.gateway import probe
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.certificates import Authority
from tests.support.tokens import key_file


async def test_a_gateway_with_the_certificate_of_another_name_is_alive(tmp_path: Path) -> None:
    cert, cert_key = Authority(tmp_path).issue()
    settings = GatewaySettings(host="0.0.0.0", port=0, auth_keys=(key_file(tmp_path),), tls_cert=cert, tls_key=cert_key)
    async with run_gateway(settings) as gateway:
        url = gateway.url.replace("0.0.0.0", "127.0.0.2") + "healthz"
        assert await asyncio.to_thread(probe.main, [url]) == 0


async def test_one_that_is_not_there_or_not_well_is_said_so(capsys: pytest.CaptureFixture[str]) -> None:
    async with run_gateway(GatewaySettings(port=0)) as gateway:
        assert await asyncio.to_thread(probe.main, [f"{gateway.url}healthz"]) == 0
        assert await asyncio.to_thread(probe.main, [f"{gateway.url}nothing"]) == 1
    for url, words in ((f"{gateway.url}healthz", "refused"), (gateway.url.replace("http", "x"), "unknown url type")):
        assert probe.main([url]) == 1
        assert words in capsys.readouterr().err
