"""The gateway's figures: what happened is in them, and the table for operators lists them all."""

import asyncio
import time
from collections.abc import AsyncIterator
from pathlib import Path

import aiohttp
import pytest

from openrois.gateway import metrics
from openrois.gateway.connection_limits import MAX_ADAPTERS, MAX_APPLICATIONS
from openrois.gateway.encryption import Certificate
from openrois.gateway.metrics import FIGURES
from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.certificates import Authority
from tests.support.deployment import Robot
from tests.support.guarded import guarded
from tests.support.scraped import scraped


@pytest.fixture
async def gateway() -> AsyncIterator[Gateway]:
    async with deployment.gateway(metrics="0") as running:
        yield running


async def test_what_happened_is_counted(gateway: Gateway) -> None:
    async with deployment.adapter(gateway, *Robot().parts()), deployment.application(gateway) as app:
        await app.ask("rois.system.connect")
        await app.ask("rois.command.bind", component_ref="robot/lamp")
        await app.ask("rois.command.bind", component_ref="robot/nothing")
        await app.ask("rois.event.subscribe", event_type="rang")
        await app.send("no JSON")
        await app.hear()
        found = await scraped(gateway)
        application = ("application",)
        assert found["openrois_gateway_connections"] == {application: 1, ("adapter",): 1}
        assert found["openrois_gateway_requests_total"][application] == 4
        assert found["openrois_gateway_refused_requests_total"][application] == 1
        assert found["openrois_gateway_violations_total"][application] == 1
        assert found["openrois_gateway_subscriptions"][application] == 1
        assert found["openrois_gateway_running_requests"][application] == 0
        assert found["openrois_gateway_adapter_up"] == {("robot",): 1}
        assert found["openrois_gateway_adapters"] == {(): 1}
        assert found["openrois_gateway_refusals_total"] == {(): 1}
        assert found["openrois_gateway_actions_total"] == {(): 1}
        assert found["openrois_gateway_leases"] == {(): 1}
        await app.ask("rois.command.release", component_ref="robot/lamp")
        found = await scraped(gateway)
        assert found["openrois_gateway_leases"] == {(): 0}
        assert found["openrois_gateway_leases_ended_total"] == {("released",): 1}
        assert found["openrois_gateway_request_seconds_count"][("rois.command.bind",)] == 2
        assert found["openrois_gateway_request_seconds_bucket"][("+Inf", "rois.command.bind")] == 2
        assert ("openrois.directory.list",) in found["openrois_gateway_call_seconds_count"]
        assert found["openrois_gateway_connections_limit"] == {
            application: MAX_APPLICATIONS,
            ("adapter",): MAX_ADAPTERS,
        }
        assert found["openrois_gateway_urgent_requests_total"][application] == 1
        assert found["openrois_gateway_draining"] == {(): 0}
        assert found["process_open_fds"][()] > 0
    async with asyncio.timeout(deployment.PATIENCE):
        while (found := await scraped(gateway))["openrois_gateway_connections"][application]:
            pass
    assert found["openrois_gateway_connections_total"][application] == 1
    assert found["openrois_gateway_requests_total"][application] == 5
    assert found["openrois_gateway_subscriptions"][application] == 0
    assert sum(found["openrois_gateway_closed_connections_total"].values()) >= 1


async def test_keys_of_an_issuer_are_fetched(tmp_path: Path) -> None:
    async with deployment.gateway(metrics="0", auth_jwks_file=tmp_path / "nothing") as gateway:
        async with aiohttp.ClientSession() as http, http.get(gateway.url + "readyz") as answer:
            assert answer.status == 503
        async with asyncio.timeout(deployment.PATIENCE):
            while not (found := await scraped(gateway))["openrois_gateway_key_fetch_failures_total"][()]:
                pass
        assert found["openrois_gateway_key_fetches_total"] == {(): 1}


async def test_when_the_certificate_ends_and_what_was_unusable(tmp_path: Path) -> None:
    cert, key = Authority(tmp_path).issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key, metrics="0") as coming:
        end = Certificate(cert, key, time.time).ends
        assert (await scraped(coming.gateway))["openrois_gateway_certificate_end_seconds"] == {(): end}
        cert.write_text("none")
        coming.gateway.reload()
        assert (await scraped(coming.gateway))["openrois_gateway_unusable_files_total"] == {(): 1}


def test_unknown_codes_share_one_sample() -> None:
    codes = metrics._codes({1000: 2, 4401: 1, 4409: 5, 4999: 3, 3000: 1})
    assert list(codes) == [("1000", 2), ("4401", 1), ("4409", 5), ("other", 4)]
    assert list(metrics._codes({})) == []


async def test_an_unknown_method_makes_no_label(gateway: Gateway) -> None:
    async with deployment.application(gateway) as app:
        await app.send({"jsonrpc": "2.0", "id": 1, "method": "x" * 50, "params": {}})
        await app.hear()
        found = await scraped(gateway)
        assert ("x" * 50,) not in found.get("openrois_gateway_request_seconds_count", {})


async def test_every_figure_is_there(gateway: Gateway) -> None:
    found = await scraped(gateway)
    labelled = {figure.name for figure in metrics.LABELLED}
    assert {figure.name for figure in FIGURES} - labelled <= set(found)
    for figure in FIGURES:
        assert figure.name.endswith("_total") is (figure.kind == "counter")
