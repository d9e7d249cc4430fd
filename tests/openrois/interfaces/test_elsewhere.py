"""What `get_command_result` answers of a command that another gateway accepted."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import StoreUnreachable
from openrois.journal.former import GATEWAY_LOST, FormerCommand
from openrois.journal.journal import NoJournal
from openrois.session.session import EngineHost
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result
from tests.support.authorization import Place, Wire, principal
from tests.support.components import Lamp

ASKED = {"command_id": "one", "condition": ""}
GIVEN = (Result(name="total", data_type_ref="integer", value="3"),)
RUNNING = FormerCommand("robot/lamp", None, "", None, is_running=True)


class Elsewhere(NoJournal):
    """A journal that other gateways write: it says how a command stands, look by look, and at last the same."""

    def __init__(self) -> None:
        super().__init__()
        self.looks: list[FormerCommand | StoreUnreachable | None] = []
        self.delivered = 0

    async def find(self, subject: str, command_id: str) -> FormerCommand | None:
        found = self.looks.pop(0) if len(self.looks) > 1 else self.looks[0]
        if isinstance(found, StoreUnreachable):
            raise found
        return found

    async def deliver_outcome(self, subject: str, command_id: str) -> FormerCommand | None:
        self.delivered += 1
        return await self.find(subject, command_id) if self.delivered == 1 else None


@dataclass
class Scene:
    journal: Elsewhere
    app: Wire
    slept: list[float] = field(default_factory=list)


@pytest.fixture
async def scene() -> AsyncIterator[Scene]:
    engine, slept = Engine("gateway"), list[float]()
    await engine.attach(LocalRegistry("robot", (Lamp(),)))

    async def sleep(seconds: float) -> None:
        slept.append(seconds)
        await asyncio.sleep(0)

    async with TaskScope() as tasks:
        journal = Elsewhere()
        here = Place(EngineHost(engine, tasks, sleep=sleep, journal=journal), {})
        async with here.application(principal("operator", "*")) as app:
            yield Scene(journal, app, slept)


async def test_the_end_of_one_that_runs_there_is_waited_for(scene: Scene) -> None:
    scene.journal.looks = [RUNNING, RUNNING, FormerCommand("robot/lamp", CompletedStatus.OK, "", GIVEN)]
    result = await scene.app.result("rois.command.get_command_result", ASKED)
    assert [each["value"] for each in result["results"]] == ["3"]
    assert len(scene.slept) == 2
    assert scene.journal.delivered == 1


async def test_one_that_runs_on_is_a_timeout_and_keeps_its_end(scene: Scene) -> None:
    scene.journal.looks = [RUNNING]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "TIMEOUT"
    assert sum(scene.slept) == 5
    assert scene.journal.delivered == 0


async def test_one_whose_gateway_dies_meanwhile_has_failed(scene: Scene) -> None:
    scene.journal.looks = [RUNNING, FormerCommand("robot/lamp", None, GATEWAY_LOST, None)]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "ERROR"
    assert scene.journal.delivered == 1


async def test_one_that_is_forgotten_meanwhile_is_not_known(scene: Scene) -> None:
    scene.journal.looks = [RUNNING, None]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "BAD_PARAMETER"


async def test_one_that_is_out_of_scope_is_not_known(scene: Scene) -> None:
    scene.journal.looks = [FormerCommand("robot/lamp", CompletedStatus.OK, "", GIVEN)]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "OK"
    scene.journal.looks = [FormerCommand("rover/lamp", CompletedStatus.OK, "", GIVEN)]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "OK"


AWAY = StoreUnreachable("the store did not answer within 1 s")


async def test_a_journal_that_does_not_answer_is_asked_again(scene: Scene) -> None:
    scene.journal.looks = [AWAY, AWAY, FormerCommand("robot/lamp", None, GATEWAY_LOST, None), AWAY]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "TIMEOUT"
    scene.journal.looks = [AWAY, FormerCommand("robot/lamp", CompletedStatus.OK, "", GIVEN)]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "OK"


async def test_one_whose_end_a_journal_does_not_tell_in_time_is_a_timeout(scene: Scene) -> None:
    scene.journal.looks = [AWAY]
    assert await scene.app.code("rois.command.get_command_result", ASKED) == "TIMEOUT"
    assert 4 < sum(scene.slept) <= 5
    assert scene.journal.delivered == 0
