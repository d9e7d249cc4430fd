"""The audit trail of a whole gateway: everything that moves something, and everything that was refused."""

import json
from pathlib import Path
from typing import Any

from openrois.auth.principal import LOCAL
from tests.support import deployment
from tests.support.deployment import Robot


def told(path: Path) -> list[tuple[str, str, str]]:
    records: list[dict[str, Any]] = [json.loads(line) for line in path.read_text().splitlines()]
    records = [record for record in records if record["kind"] != "session"]
    assert all(record["who"] == LOCAL.subject for record in records)
    assert [record["time"] for record in records] == sorted(record["time"] for record in records)
    assert all("/req-" in record["correlation"] for record in records if not record["method"].startswith("lease."))
    return [(record["kind"], record["method"], record.get("subject", "")) for record in records]


async def test_what_is_done_and_what_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "audit"
    async with (
        deployment.gateway(audit_file=path) as gateway,
        deployment.adapter(gateway, *Robot().parts()),
        deployment.application(gateway) as app,
        deployment.application(gateway) as other,
    ):
        await app.ask("rois.command.search")
        unit = {"component_ref": "robot/lamp", "command_type": "switch", "command_id": "1", "arguments": []}
        await app.ask("rois.command.execute", command_unit_list=[unit])
        await app.ask("rois.command.bind", component_ref="robot/lamp")
        await app.ask("rois.command.execute", command_unit_list=[unit])
        await app.completed("1")
        await other.ask("rois.command.bind", component_ref="robot/lamp")
        await other.ask("rois.query.query", query_type="view", condition="no condition")
        await app.ask("rois.command.release", component_ref="robot/lamp")
        await other.ask("rois.command.bind_any", condition="component_ref = 'robot/lamp'")
        await other.ask("rois.system.disconnect")
    assert told(path) == [
        ("refused", "rois.command.execute", "robot/lamp"),
        ("acted", "rois.command.bind", "robot/lamp"),
        ("acted", "rois.command.execute", "robot/lamp"),
        ("refused", "rois.command.bind", "robot/lamp"),
        ("refused", "rois.query.query", "no condition"),
        ("acted", "rois.command.release", "robot/lamp"),
        ("acted", "rois.command.bind", "robot/lamp"),
        ("acted", "lease.lost", "robot/lamp"),
    ]
    details = [line for line in map(json.loads, path.read_text().splitlines()) if line["kind"] != "session"]
    assert details[2]["detail"] == "switch 1"
    assert details[3]["reason"].startswith("OUT_OF_RESOURCES: ")
    assert details[7]["detail"].endswith(": left")
