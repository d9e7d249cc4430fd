"""Which refusals of an application are recorded, and what becomes of a flood of them."""

import json
from pathlib import Path
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.gateway.refusals import REFUSALS_AT_ONCE, REFUSALS_PER_SECOND, RefusalNotes
from openrois.observability.audit import Audit
from openrois.session.session import ApplicationSession, EngineHost
from openrois.types.codes import ReturnCode
from openrois.types.messages import ReturnResult
from tests.support.authorization import place, principal
from tests.support.clock import Clock

REFUSED = ReturnResult(return_code=ReturnCode.UNSUPPORTED)


def told(path: Path) -> list[dict[str, Any]]:
    return [line for line in map(json.loads, path.read_text().splitlines()) if line["kind"] != "session"]


async def test_a_flood_is_cut_and_counted(tmp_path: Path) -> None:
    clock = Clock()
    async with TaskScope() as tasks:
        with Audit(tmp_path / "audit") as audit:
            notes = RefusalNotes(ApplicationSession(host := EngineHost(Engine("g"), tasks, audit=audit), print), clock)
            for _ in range(REFUSALS_AT_ONCE + 50):
                notes.note("m", {"component_ref": "robot/arm"}, REFUSED, "no")
            clock.now = 1.0
            for _ in range(REFUSALS_PER_SECOND + 5):
                notes.note("m", {}, REFUSED, "no")
            assert host.audit.refusals == REFUSALS_AT_ONCE + REFUSALS_PER_SECOND
    reasons = [record["reason"] for record in told(tmp_path / "audit")]
    assert len(reasons) == REFUSALS_AT_ONCE + REFUSALS_PER_SECOND
    assert reasons[REFUSALS_AT_ONCE] == "UNSUPPORTED: no (and 50 more refusals before)"
    assert set(reasons[:REFUSALS_AT_ONCE]) == {"UNSUPPORTED: no"}


@pytest.mark.parametrize(
    ("params", "result", "subject"),
    [
        ({"component_ref": "robot/arm"}, REFUSED, "robot/arm"),
        ({"command_unit_list": [{"component_ref": "robot/arm"}]}, {"return_code": "UNSUPPORTED"}, "robot/arm"),
        ({"command_unit_list": ["x"], "condition": "c"}, REFUSED, "c"),
        ({"command_unit_list": {}, "peer_id": ["a"]}, REFUSED, "['a']"),
        ({}, REFUSED, ""),
        ({}, ReturnResult(return_code=ReturnCode.TIMEOUT), None),
        ({}, {"return_code": "ERROR"}, None),
        ({}, None, None),
    ],
)
async def test_what_a_refusal_is_about(
    params: dict[str, Any], result: Any, subject: str | None, tmp_path: Path
) -> None:
    async with TaskScope() as tasks:
        with Audit(tmp_path / "audit") as audit:
            notes = RefusalNotes(ApplicationSession(EngineHost(Engine("g"), tasks, audit=audit), print))
            notes.note("m", params, result, "no")
    assert [record.get("subject", "") for record in told(tmp_path / "audit")] == ([] if subject is None else [subject])


async def test_the_trail_alone_tells_what_is_out_of_scope_from_what_is_not_there(tmp_path: Path) -> None:
    status = {"query_type": "component_status", "condition": "component_ref = 'fleet/move'"}
    unit = {"component_ref": "fleet/move", "command_type": "stop", "command_id": "c"}
    asked: list[tuple[str, dict[str, Any], str]] = [
        ("rois.command.bind", {"component_ref": "fleet/move"}, "fleet/move"),
        ("rois.query.query", status, "fleet/move"),
        ("rois.command.execute", {"command_unit_list": [{"command_list": [unit]}]}, "fleet/move"),
        ("rois.stream.connect_stream", {"component_ref": "fleet/none"}, ""),
        ("rois.event.subscribe", {"event_type": "e", "condition": "component_ref = 'it''s not there'"}, ""),
        ("rois.command.execute", {"command_unit_list": [unit | {"component_ref": "none/move"}]}, ""),
    ]
    with Audit(tmp_path / "audit") as audit:
        async with place("fleet", audit=audit) as where, where.application(principal("operator", "fleet/x")) as wire:
            for method, params, _ in asked:
                assert await wire.code(method, params) == "UNSUPPORTED"
    records = told(tmp_path / "audit")
    assert [record["method"] for record in records] == [method for method, _, _ in asked]
    for record, (_, _, hidden) in zip(records, asked, strict=True):
        assert record["who"] == "anna"
        assert ("(out of scope: fleet/move)" in record["reason"]) == bool(hidden)


async def test_a_method_that_no_role_may_call_is_in_the_trail(tmp_path: Path) -> None:
    with Audit(tmp_path / "audit") as audit:
        async with place("fleet", audit=audit) as where, where.application(principal("viewer", "*")) as wire:
            assert await wire.code("rois.command.bind", {"component_ref": "fleet/move"}) == "UNSUPPORTED"
    (record,) = told(tmp_path / "audit")
    assert (record["method"], record["subject"]) == ("rois.command.bind", "fleet/move")
    assert record["reason"] == "UNSUPPORTED: rois.command.bind is not for the roles of this application"
