"""Sign-ins and sign-outs in the audit trail."""

import json
from pathlib import Path
from typing import Any

import pytest

from openrois.auth.principal import Principal, Role
from openrois.gateway import sign_in
from openrois.gateway.sign_in import SignIns
from openrois.observability.audit import Audit
from tests.support.clock import Clock
from tests.support.guarded import ask, fresh, guarded

ANNA = Principal("anna", frozenset({Role.OPERATOR, Role.VIEWER}), ("*",), token_id="t1")


def sessions(path: Path) -> list[dict[str, Any]]:
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return [line for line in lines if line["kind"] == "session"]


async def test_sign_ins_and_sign_outs_are_recorded_beside_actions(tmp_path: Path) -> None:
    async with guarded(tmp_path) as coming:
        async with coming.dial(fresh(sub="anna", roles=["operator", "viewer"], jti="t1")) as connection:
            await ask(connection, "rois.system.connect")
            await connection.close(1000, "that is all")
        async with coming.dial(fresh(sub="robot", roles="adapter", scope="robot/*"), path="adapter") as connection:
            connection.transport.abort()
    came, left, adapter_came, adapter_left = sessions(tmp_path / "audit.jsonl")
    assert (came["who"], came["subject"], came["token_id"]) == ("anna", "/", "t1")
    assert came["detail"] == "signed in as operator, viewer from 127.0.0.1"
    assert (left["who"], left["token_id"]) == ("anna", "t1")
    assert left["detail"] == "signed out: closed with 1000 that is all"
    assert came["correlation"] == left["correlation"] != ""
    assert (adapter_came["who"], adapter_came["subject"]) == ("robot", "/adapter")
    assert adapter_came["detail"] == "signed in as adapter from 127.0.0.1"
    assert adapter_left["detail"].startswith("signed out: closed with 1006")
    assert adapter_left["correlation"] != came["correlation"]


async def test_a_refused_client_has_not_signed_in(tmp_path: Path) -> None:
    async with guarded(tmp_path) as coming:
        with pytest.raises(Exception, match="401"):
            await coming.dial("x.y.z")
    assert sessions(tmp_path / "audit.jsonl") == []
    assert [line["reason"] for line in coming.audited()] == ["malformed"]


def test_a_flood_of_connections_does_not_fill_the_trail(tmp_path: Path) -> None:
    clock, path = Clock(), tmp_path / "audit.jsonl"
    with Audit(path) as audit:
        sign_ins = SignIns(audit, clock)
        for _ in range(sign_in.RECORDED_AT_ONCE + 5):
            with sign_ins.visit(ANNA, "/", "") as visit:
                visit.ended = "closed with 1000"
        clock.now += 1
        with sign_ins.visit(ANNA, "/", ""):
            pass
    lines = [line["detail"] for line in sessions(path)]
    assert len(lines) == 2 * (sign_in.RECORDED_AT_ONCE + 1)
    assert lines[:2] == ["signed in as operator, viewer", "signed out: closed with 1000"]
    assert lines[-2:] == [
        "signed in as operator, viewer (and 5 more sign-ins before)",
        "signed out: without a farewell (and 5 more sign-outs before)",
    ]
