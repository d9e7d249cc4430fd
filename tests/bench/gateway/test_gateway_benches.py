"""The benches of the gateway with real processes, as short as they can be: what they say is for a quiet machine."""

import json
from pathlib import Path

import pytest
from openrois_bench import command
from openrois_bench.gateway.fleet.__main__ import measured
from openrois_bench.gateway.rpc import RpcSettings, run_rpc


async def test_rpc_measures_gateway_and_floor() -> None:
    said: list[str] = []
    report = await run_rpc(RpcSettings(rounds=1, seconds=0.1, requests=20, clients=2), said.append)
    assert len(said) == 1
    assert "query through the gateway" in str(report)
    assert report.tcp.count == report.query.count == 20
    assert min(report.tcp.p50, report.query.p50) > 0
    assert report.pipelined.per_second > 0


@pytest.mark.long
def test_events_reach_all_permitted_subscribers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "events.json"
    asked = ["events", "--rounds", "1", "--seconds", "0.2", "--clients", "3", "--tls", "--auth", "--json", str(file)]
    assert command.main(asked) == 0
    assert "TLS, tokens, authorization and audit" in capsys.readouterr().out
    figures = json.loads(file.read_text())
    assert figures["bench"] == "events"
    assert 0 < figures["first"]["p50"] <= figures["last"]["p50"]


@pytest.mark.long
def test_idle_connections_stay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "idle.json"
    assert command.main(["idle", "--connections", "5", "--seconds", "0.1", "--json", str(file)]) == 0
    assert "5 idle connections" in capsys.readouterr().out
    assert json.loads(file.read_text())["full"] > 10


@pytest.mark.long
async def test_a_fleet_is_attached_listed_and_searched() -> None:
    (found,) = await measured((110,), 3)
    assert found["bodies"] == 110
    assert found["attach_ms"] > 0
    assert found["attach_with_scopes_ms"] is not None
    assert 0 < found["change_bytes"] < 50_000
    assert found["search_hits"] == [17, 10, 1]
