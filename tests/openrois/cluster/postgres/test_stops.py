"""STOP over a real PostgreSQL server: answered in time, not answered, several at once, and garbage in between."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass

import pytest

from openrois.cluster.postgres import stops as module
from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.stop_messages import StopAnswer, StopAsked, answer_texts
from openrois.cluster.postgres.stops import ANSWER_TIME, Stops
from openrois.errors import OutOfResources, StoreUnreachable
from tests.support.ownership import PATIENT
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

LATE = 0.05
"""Seconds that are waited for an answer that does not come."""


async def stop(engine_id: str, subject: str, _rank: str, _stop_id: str) -> StopAnswer:
    return StopAnswer(stopped=(f"{engine_id}/lamp",), failed=(f"{engine_id}/arm",), problem=f"for {subject}")


async def until_linked(database: Database) -> None:
    """Wait until the database's notifications are heard."""
    async with asyncio.timeout(PATIENT):
        while True:
            try:
                async with database.link() as link:
                    await link.execute("SELECT 1")
                    return
            except StoreUnreachable:
                await asyncio.sleep(0)


@dataclass
class Gateways:
    server: Server
    front: Stops
    owner: Stops
    another: Stops

    async def notify(self, *texts: str) -> None:
        """Notify texts beside what is tested."""
        async with self.server.admin() as admin:
            for text in texts:
                await admin.execute("SELECT pg_notify('openrois', $1)", text)


@pytest.fixture
async def gateways(postgres_server: Server) -> AsyncIterator[Gateways]:
    async with postgres_server.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
    async with AsyncExitStack() as stack:
        made = []
        for name in ("front", "owner", "another"):
            database = Database(postgres_server.url, postgres_server.password_file, gateway_id=name)
            await stack.enter_async_context(database)
            await until_linked(database)
            made.append(await stack.enter_async_context(Stops(database, name)))
        yield Gateways(postgres_server, *made)


async def test_the_owner_answers_what_has_stopped_and_what_has_not(gateways: Gateways) -> None:
    gateways.owner.serve(stop)
    gateways.another.serve(lambda *_asked: pytest.fail("it is not this gateway's engine"))
    answer = await gateways.front.ask("owner", "robot", "ann", PATIENT)
    assert answer == StopAnswer(("robot/lamp",), ("robot/arm",), problem="for ann")


async def test_an_answer_that_one_notification_does_not_carry_comes_whole(gateways: Gateways) -> None:
    refs = tuple(f"robot/{'ü' * 100}{number}" for number in range(150))

    async def stop_all(_engine_id: str, _subject: str, _rank: str, _stop_id: str) -> StopAnswer:
        return StopAnswer(stopped=refs)

    gateways.owner.serve(stop_all)
    assert (await gateways.front.ask("owner", "robot", "ann", PATIENT)).stopped == refs


async def test_an_owner_that_does_not_answer_is_waited_for_briefly(gateways: Gateways) -> None:
    leave = gateways.owner.serve(stop)
    leave()
    answer = await gateways.front.ask("owner", "robot", "ann", LATE)
    assert not answer.is_answered
    assert answer.problem == f"gateway owner did not answer within 0.05 s over {gateways.front._database.name}"
    assert gateways.front._questions == {}
    began = asyncio.get_running_loop().time()
    assert not (await gateways.front.ask("gone", "robot", "ann")).is_answered
    assert asyncio.get_running_loop().time() - began >= ANSWER_TIME


async def test_an_answer_that_comes_late_is_no_answer_to_the_next_question(gateways: Gateways) -> None:
    may_answer = asyncio.Event()
    has_answered = asyncio.Event()

    async def stop_late(engine_id: str, subject: str, rank: str, stop_id: str) -> StopAnswer:
        await may_answer.wait()
        has_answered.set()
        return await stop(engine_id, subject, rank, stop_id)

    gateways.owner.serve(stop_late)
    assert not (await gateways.front.ask("owner", "robot", "ann", LATE)).is_answered
    may_answer.set()
    await has_answered.wait()
    gateways.owner.serve(stop)
    answer = await gateways.front.ask("owner", "rover", "bob", PATIENT)
    assert (answer.stopped, answer.problem) == (("rover/lamp",), "for bob")


async def test_two_at_once_have_each_their_own_answer(gateways: Gateways) -> None:
    gateways.owner.serve(stop)
    gateways.front.serve(stop)
    asks = [
        *(gateways.front.ask("owner", f"robot-{number}", "ann", PATIENT) for number in range(5)),
        *(gateways.owner.ask("front", f"robot-{number}", "bob", PATIENT) for number in range(5)),
    ]
    answers = await asyncio.gather(*asks)
    assert [each.stopped for each in answers] == [(f"robot-{number}/lamp",) for number in range(5)] * 2


async def test_garbage_on_the_channel_changes_nothing(gateways: Gateways) -> None:
    gateways.owner.serve(stop)
    asked = StopAsked(id="0" * 32, asker="front", owner="owner", engine_id="robot", subject="ann")
    unasked = answer_texts(asked, StopAnswer(stopped=("robot/lie",)))[0]
    await gateways.notify("", "stop", "stop ", "stop {}", "stop asked nonsense", "stop told []", f"stop {unasked}")
    assert (await gateways.front.ask("owner", "robot", "ann", PATIENT)).stopped == ("robot/lamp",)
    assert gateways.owner.garbage == gateways.front.garbage == 5


@pytest.mark.parametrize(
    ("error", "problem"),
    [
        (OutOfResources("the engine is not here"), "the engine is not here"),
        (RuntimeError("hidden"), "stopping failed inside the gateway"),
    ],
)
async def test_an_owner_that_fails_says_so(gateways: Gateways, error: Exception, problem: str) -> None:
    async def fail(_engine_id: str, _subject: str, _rank: str, _stop_id: str) -> StopAnswer:
        raise error

    gateways.owner.serve(fail)
    assert await gateways.front.ask("owner", "robot", "ann", PATIENT) == StopAnswer(problem=problem)


async def test_an_owner_that_takes_too_long_says_so(gateways: Gateways, monkeypatch: pytest.MonkeyPatch) -> None:
    async def hang(_engine_id: str, _subject: str, _rank: str, _stop_id: str) -> StopAnswer:
        await asyncio.Event().wait()
        raise AssertionError

    monkeypatch.setattr(module, "STOPPING_TIME", 0.01)
    gateways.owner.serve(hang)
    answer = await gateways.front.ask("owner", "robot", "ann", PATIENT)
    assert answer == StopAnswer(problem="stopping takes longer than 0.01 s")


async def test_a_gateway_waits_for_so_many_answers_and_an_owner_works_at_so_many(
    gateways: Gateways, monkeypatch: pytest.MonkeyPatch
) -> None:
    may_stop = asyncio.Event()
    is_asked = asyncio.Semaphore(0)

    async def stop_later(engine_id: str, subject: str, rank: str, stop_id: str) -> StopAnswer:
        is_asked.release()
        await may_stop.wait()
        return await stop(engine_id, subject, rank, stop_id)

    gateways.owner.serve(stop_later)
    monkeypatch.setattr(module, "MAX_SERVED", 2)
    monkeypatch.setattr(module, "MAX_ASKED", 3)
    async with asyncio.TaskGroup() as tasks:
        asks = [tasks.create_task(gateways.front.ask("owner", "robot", "ann", PATIENT)) for _ in range(2)]
        async with asyncio.timeout(PATIENT):
            for _ in range(2):
                await is_asked.acquire()
        third = tasks.create_task(gateways.front.ask("owner", "robot", "ann", LATE * 10))
        await asyncio.sleep(0)
        refused = await gateways.front.ask("owner", "robot", "ann", PATIENT)
        assert refused.problem == "3 other STOPs wait for an answer: ask again"
        assert not (await third).is_answered
        may_stop.set()
    assert gateways.owner.turned_away == 1
    assert all(each.result().is_answered for each in asks)


async def test_a_server_that_is_gone_is_told_at_once(gateways: Gateways) -> None:
    gateways.owner.serve(stop)
    gateways.server.kill()
    try:
        answer = await gateways.front.ask("owner", "robot", "ann", PATIENT)
        assert not answer.is_answered
        assert answer.problem.startswith("PostgreSQL ")
    finally:
        gateways.server.start()
