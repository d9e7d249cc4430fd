"""Which refusals of an application are recorded, and what becomes of a flood of them."""

import json
from pathlib import Path
from typing import Any

import pytest

from openrois.application import ApplicationSession, EngineHost
from openrois.audit import Audit
from openrois.engine import Engine
from openrois.gateway.refusals import REFUSALS_AT_ONCE, REFUSALS_PER_SECOND, RefusalNotes
from openrois.tasks import TaskScope
from openrois.types.codes import ReturnCode
from openrois.types.messages import ReturnResult
from tests.support.clock import Clock

REFUSED = ReturnResult(return_code=ReturnCode.UNSUPPORTED)


def told(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


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
