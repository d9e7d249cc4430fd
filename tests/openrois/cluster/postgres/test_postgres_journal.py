"""The journal that gateways share: which of them is dead, that an end is told once, and what a lost server changes."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager
from typing import Any

import pytest

from openrois.cluster.postgres import journal as module
from openrois.journal.former import GATEWAY_LOST
from openrois.journal.records import Accepted
from openrois.types.codes import CompletedStatus
from tests.support.journals import in_postgres_journal, until_written
from tests.support.postgres import Server

pytestmark = pytest.mark.extra(name="cluster")

OK = CompletedStatus.OK
EXPIRED = 0
"""Milliseconds of a registration that is over at once."""

Run = Callable[..., AbstractAsyncContextManager[Any]]


@pytest.fixture
async def run(postgres_server: Server) -> AsyncIterator[Run]:
    async with in_postgres_journal(postgres_server) as made:
        yield made


@pytest.fixture
async def admin(postgres_server: Server, run: Run) -> AsyncIterator[Any]:
    async with postgres_server.admin() as connection:
        yield connection


async def let_expire(admin: Any, gateway_id: str = "a") -> None:
    """Let a gateway's registration be over, as when it does not renew any more."""
    await admin.execute("UPDATE openrois.gateway SET expires_ms = 1, ttl_ms = 10000 WHERE gateway_id = $1", gateway_id)


class TestOtherGateways:
    async def test_a_command_runs_at_a_gateway_that_is_there(self, run: Run) -> None:
        async with run("a") as a, run("b") as b:
            await a.accepted("s", "ann", {"one": "robot/lamp"})
            former = await b.find("ann", "one")
            assert former.is_running
            assert (former.component_ref, former.status, former.reason) == ("robot/lamp", None, "")
            assert await b.deliver_outcome("ann", "one") is None
            a.ended("s", "one", OK, "", ())
            await until_written(a)
            assert (await b.deliver_outcome("ann", "one")).status is OK
            assert not (await b.find("ann", "one")).is_running

    async def test_a_command_of_a_gateway_that_has_expired_was_lost_with_it(self, run: Run, admin: Any) -> None:
        async with run("a") as a, run("b") as b:
            await a.accepted("s", "ann", {"one": "robot/lamp", "two": "robot/lamp"})
            a.ended("s", "two", OK, "", ())
            await until_written(a)
            await let_expire(admin)
            former = await b.find("ann", "one")
            assert (former.status, former.reason, former.is_running) == (None, GATEWAY_LOST, False)
            assert (await b.deliver_outcome("ann", "one")).reason == GATEWAY_LOST
            assert (await b.find("ann", "two")).status is OK
            # It was told as lost, and that was its end.
            a.ended("s", "one", OK, "", ())
            await until_written(a)
            former = await b.find("ann", "one")
            assert (former.status, former.reason, former.is_notified) == (None, GATEWAY_LOST, True)

    async def test_a_command_is_lost_with_the_engine_that_another_gateway_has_claimed(
        self, run: Run, admin: Any
    ) -> None:
        claim = "INSERT INTO openrois.claim VALUES ('robot', $1, 'process', 1)"
        claim += " ON CONFLICT (engine_id) DO UPDATE SET gateway_id = excluded.gateway_id"
        async with run("a") as a, run("b") as b:
            await a.accepted("s", "ann", {"one": "robot/lamp", "other": "robots/lamp"})
            for owner, is_running in (("a", True), ("", True), ("b", False), ("c", False)):
                await admin.execute(claim, owner)
                assert (await b.find("ann", "one")).is_running is is_running
                assert (await b.find("ann", "other")).is_running
            assert (await b.deliver_outcome("ann", "one")).reason == GATEWAY_LOST

    async def test_one_that_was_started_again_has_lost_what_ran(self, run: Run) -> None:
        async with run("b") as b, run("a") as former:
            await former.accepted("s", "ann", {"one": "robot/lamp"})
            async with run("a") as present:
                assert (await b.find("ann", "one")).reason == GATEWAY_LOST
                assert (await present.find("ann", "one")).reason == GATEWAY_LOST

    @pytest.mark.parametrize("contact", [0.0, 9.9])
    async def test_none_is_dead_while_it_had_no_time_to_renew(self, run: Run, admin: Any, contact: float) -> None:
        async with run("a") as a, run("b", contact=contact) as b:
            await a.accepted("s", "ann", {"one": "robot/lamp"})
            await let_expire(admin)
            assert (await b.find("ann", "one")).is_running
            await admin.execute("DELETE FROM openrois.gateway WHERE gateway_id = 'a'")
            assert (await b.find("ann", "one")).is_running
            assert await b.deliver_outcome("ann", "one") is None

    async def test_one_that_the_store_does_not_know_is_dead_after_a_while(self, run: Run, admin: Any) -> None:
        async with run("a") as a, run("b", contact=10.0) as b:
            await a.accepted("s", "ann", {"one": "robot/lamp"})
            await admin.execute("DELETE FROM openrois.gateway WHERE gateway_id = 'a'")
            assert (await b.find("ann", "one")).reason == GATEWAY_LOST

    async def test_of_gateways_that_are_asked_at_once_one_delivers(self, run: Run, admin: Any) -> None:
        async with run("a") as a, run("b") as b, run("c") as c:
            await a.accepted("s", "ann", {"one": "robot/lamp", "two": "robot/lamp"})
            a.ended("s", "two", OK, "", ())
            await until_written(a)
            await let_expire(admin)
            for command_id in ("one", "two"):
                asked = (each.deliver_outcome("ann", command_id) for each in (b, c) * 5)
                told = await asyncio.gather(*asked)
                assert len([each for each in told if each is not None]) == 1


class TestWriting:
    async def test_a_command_goes_on_without_a_server_that_is_slow(self, run: Run, admin: Any) -> None:
        async with run("a", patience=0.05) as a:
            async with admin.transaction():
                await admin.execute("LOCK TABLE openrois.command IN ACCESS EXCLUSIVE MODE")
                await a.accepted("s", "ann", {"one": "robot/lamp"})
                assert (a.late, a.waiting) == (1, 1)
            await until_written(a)

    async def test_what_a_dead_server_does_not_take_is_counted_and_written_later(
        self, postgres_server: Server, run: Run, caplog: pytest.LogCaptureFixture
    ) -> None:
        may_retry = asyncio.Event()

        async def sleep(_seconds: float) -> None:
            await may_retry.wait()
            await asyncio.sleep(0.01)

        caplog.set_level(logging.INFO)
        async with run("a", sleep=sleep) as a, run("b") as b:
            postgres_server.kill()
            try:
                for number in range(5):
                    await a.accepted("s", "ann", {str(number): "robot/lamp"})
                    a.ended("s", str(number), OK, "", ())
                assert a.failing
                assert (a.waiting, a.lost, a.late) == (10, 0, 0)
                assert a.failures >= 1
            finally:
                postgres_server.start()
            may_retry.set()
            await until_written(a)
            said = [each for each in caplog.messages if each.startswith("the journal")]
            assert len(said) == 2
            assert "cannot be written: PostgreSQL" in said[0]
            assert said[1].endswith("is written again")
            assert (await b.find("ann", "4")).status is OK

    async def test_what_finds_no_room_in_the_shared_journal_is_lost_and_counted(self, run: Run, admin: Any) -> None:
        async with run("a", most=3, patience=0) as a:
            async with admin.transaction():
                await admin.execute("LOCK TABLE openrois.command IN ACCESS EXCLUSIVE MODE")
                for number in range(5):
                    a.ended("s", str(number), OK, "", ())
                assert (a.waiting, a.lost) == (3, 2)
                await a.accepted("s", "ann", {"one": "robot/lamp"})
                assert (a.lost, a.late) == (3, 0)
            await until_written(a)

    async def test_a_batch_whose_answer_was_lost_changes_nothing_when_it_comes_again(self, run: Run) -> None:
        async with run("a") as a, run("b") as b:
            await a.accepted("s", "ann", {"one": "robot/lamp"})
            a.ended("s", "one", OK, "", ())
            first = list(a._queue)
            await until_written(a)
            assert (await b.deliver_outcome("ann", "one")).status is OK
            again = module._Waiting(1, Accepted("s", "one", "ann", "robot/lamp", 0.0), None)
            a._queue.extend([again, *first])
            assert await a._write()
            former = await b.find("ann", "one")
            assert (former.status, former.is_notified) == (OK, True)

    async def test_an_id_that_is_used_again_means_the_new_command(self, run: Run, admin: Any) -> None:
        async with run("a", patience=0) as a, run("b") as b:
            async with admin.transaction():
                await admin.execute("LOCK TABLE openrois.command IN ACCESS EXCLUSIVE MODE")
                for component_ref in ("robot/lamp", "robot/voice"):
                    await a.accepted("s", "ann", {"one": component_ref})
                    a.ended("s", "one", OK, component_ref, ())
                await a.accepted("s", "ann", {"one": "robot/eye"})
            await until_written(a)
            former = await b.find("ann", "one")
            assert (former.component_ref, former.is_running) == ("robot/eye", True)

    async def test_a_gateway_that_ends_says_what_is_not_written(
        self, run: Run, admin: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
    ) -> None:
        monkeypatch.setattr(module, "_CLOSING", 0.01)
        async with admin.transaction():
            await admin.execute("LOCK TABLE openrois.command IN ACCESS EXCLUSIVE MODE")
            async with run("a", patience=0) as a:
                await a.accepted("s", "ann", {"one": "robot/lamp"})
        assert a.lost == 1
        assert caplog.messages[-1].endswith("ends without 1 records")


class TestRetention:
    async def test_so_many_ended_commands_of_a_gateway_are_kept(
        self, run: Run, admin: Any, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(module, "MAX_ENDED", 10)
        monkeypatch.setattr(module, "_PRUNE_AFTER", 20)
        async with run("b") as b:
            await b.accepted("s", "bob", {"of another": "robot/lamp"})
            for _ in range(3):
                async with run("a") as a:
                    await a.accepted("s", "ann", {"runs": "robot/lamp"})
                    for number in range(40):
                        await a.accepted("s", "ann", {str(number): "robot/lamp"})
                        a.ended("s", str(number), OK, "", ())
                    await until_written(a)
            kept = await admin.fetchval("SELECT count(*) FROM openrois.command WHERE gateway_id = 'a'")
            assert 10 <= kept <= 10 + 20 + 3
            assert await admin.fetchval("SELECT count(*) FROM openrois.command WHERE gateway_id = 'b'") == 1

    async def test_shared_commands_without_a_query_are_dropped_after_days(self, run: Run, admin: Any) -> None:
        async with run("a") as a:
            await a.accepted("s", "ann", {"old": "robot/lamp", "new": "robot/lamp"})
        await admin.execute("UPDATE openrois.command SET accepted_ms = accepted_ms - 604801000 WHERE number = 1")
        async with run("b") as b:
            await b.accepted("s", "bob", {"one": "robot/lamp"})
            await until_written(b)
            assert await b.find("ann", "old") is None
            assert await b.find("ann", "new") is not None
