"""A gateway that is started again: what was accepted before gets its one end."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from openrois.gateway.server import Gateway
from openrois.journal.sqlite_journal import SqliteJournal
from tests.support import deployment
from tests.support.deployment import Application, Robot, adapter, application

LAMP = "robot/lamp"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


@asynccontextmanager
async def running(path: Path, robot: Robot) -> AsyncIterator[tuple[Gateway, Application]]:
    async with (
        deployment.gateway(journal=path) as gateway,
        adapter(gateway, *robot.parts()),
        application(gateway) as app,
    ):
        yield gateway, app


def unit(command_type: str, command_id: str) -> dict[str, object]:
    return {"component_ref": LAMP, "command_type": command_type, "command_id": command_id, "arguments": []}


async def killed(path: Path, robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a gateway in which one command ends and one runs, and end it without any message."""
    async with running(path, robot) as (_, app):
        await app.code("rois.command.bind", component_ref=LAMP)
        assert await app.code("rois.command.execute", command_unit_list=[unit("switch", "ended")]) == "OK"
        await app.completed("ended")
        await app.ask("openrois.hello", version="1")
        assert await app.code("rois.command.execute", command_unit_list=[unit("fail", "failed")]) == "OK"
        await app.completed("failed")
        units = [unit("start", "running"), unit("switch", "waiting")]
        assert await app.code("rois.command.execute", command_unit_list=units) == "OK"
        # As when the process is killed: what the end of the gateway does to commands is not written down.
        monkeypatch.setattr(SqliteJournal, "ended", lambda *_ended: None)
    monkeypatch.undo()


async def test_what_ran_ends_with_error_when_it_is_queried(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    await killed(path, Robot(), monkeypatch)
    async with running(path, Robot()) as (_, app):
        await app.ask("openrois.hello", version="1")
        for command_id in ("running", "waiting"):
            asked = {"command_id": command_id, "condition": ""}
            assert await app.why("rois.command.get_command_result", **asked) == ("ERROR", "the gateway was restarted")
            assert await app.completed(command_id) == {command_id: "ERROR"}
            assert app.reasons[command_id] == "the gateway was restarted"
            assert await app.code("rois.command.get_command_result", **asked) == "ERROR"
        result = await app.ask("rois.command.get_command_result", command_id="ended", condition="")
        assert [each["value"] for each in result["results"]] == ["1"]
        assert await app.completed("ended") == {"ended": "OK"}
        assert "ended" not in app.reasons
        failed = await app.ask("rois.command.get_command_result", command_id="failed", condition="")
        assert failed["results"] == []
        assert await app.completed("failed") == {"failed": "ERROR"}
        assert app.reasons["failed"] == "the bulb is gone"
        assert await app.code("rois.command.get_command_result", command_id="never", condition="") == "BAD_PARAMETER"
        assert await app.settled() == []
    # It has been told: another restart does not tell it again.
    async with running(path, Robot()) as (_, app):
        for command_id in ("running", "waiting", "ended", "failed"):
            asked = {"command_id": command_id, "condition": ""}
            assert await app.code("rois.command.get_command_result", **asked) == "BAD_PARAMETER"


async def test_an_id_may_be_used_again_and_means_the_new_command(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    await killed(path, Robot(), monkeypatch)
    async with running(path, Robot()) as (_, app):
        await app.code("rois.command.bind", component_ref=LAMP)
        assert await app.code("rois.command.execute", command_unit_list=[unit("switch", "running")]) == "OK"
        assert await app.completed("running") == {"running": "OK"}
        result = await app.ask("rois.command.get_command_result", command_id="running", condition="")
        assert [each["value"] for each in result["results"]] == ["1"]
        assert await app.settled() == []
