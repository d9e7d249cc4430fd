"""What gateways rely on in every journal: in a file, and in PostgreSQL."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from openrois.errors import ComponentFailed
from openrois.journal.former import FormerCommand
from openrois.journal.journal import Journal, NoJournal
from openrois.journal.records import MAX_RESULTS
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result
from tests.support.journals import MakeJournal, in_a_file, in_postgres_journal

OK, ABORT = CompletedStatus.OK, CompletedStatus.ABORT


def given(value: str = "3") -> tuple[Result, ...]:
    return (Result(name="total", data_type_ref="integer", value=value),)


async def found(journal: Journal, subject: str, command_id: str) -> FormerCommand:
    former = await journal.find(subject, command_id)
    assert former is not None
    return former


@pytest.fixture(
    params=[
        pytest.param("sqlite", marks=pytest.mark.extra(name="base")),
        pytest.param("postgres", marks=pytest.mark.extra(name="cluster")),
    ]
)
async def run(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[MakeJournal]:
    if request.param == "sqlite":
        yield in_a_file(tmp_path / "journal")
    else:
        async with in_postgres_journal(request.getfixturevalue("postgres_server")) as made:
            yield made


async def test_a_command_is_written_before_it_is_accepted(run: MakeJournal) -> None:
    async with run() as journal:
        await journal.accepted("s", "ann", {"one": "robot/lamp", "two": "robot/voice"})
        assert (journal.written, journal.waiting, journal.late, journal.failing) == (2, 0, 0, False)
        assert (journal.lost, journal.failures) == (0, 0)


async def test_the_next_run_knows_what_ran_and_how_the_others_ended(run: MakeJournal) -> None:
    async with run() as journal:
        await journal.accepted("s", "ann", {"runs": "robot/lamp", "ended": "robot/voice", "failed": "robot/lamp"})
        journal.ended("s", "ended", OK, "", given())
        journal.ended("s", "failed", ABORT, "it was stopped", ())
    for _ in range(2):
        async with run() as again:
            runs = await found(again, "ann", "runs")
            assert (runs.component_ref, runs.completed_status) == ("robot/lamp", CompletedStatus.ERROR)
            assert not runs.is_running
            with pytest.raises(ComponentFailed, match=r"the gateway (was restarted|that ran the command was lost)"):
                runs.results()
            ended, failed = await found(again, "ann", "ended"), await found(again, "ann", "failed")
            assert (ended.component_ref, ended.status, ended.reason) == ("robot/voice", OK, "")
            assert ended.results() == given()
            assert (failed.status, failed.reason, failed.results()) == (ABORT, "it was stopped", ())
            assert await again.find("bob", "ended") is None
            assert await again.find("ann", "never") is None


async def test_what_this_run_accepted_is_known_to_its_session_alone(run: MakeJournal) -> None:
    async with run() as journal:
        await journal.accepted("s", "ann", {"one": "robot/lamp"})
        assert await journal.find("ann", "one") is None
        assert await journal.deliver_outcome("ann", "one") is None


async def test_an_end_is_delivered_once(run: MakeJournal) -> None:
    async with run() as journal:
        await journal.accepted("s", "ann", {"runs": "robot/lamp", "ended": "robot/lamp"})
        journal.ended("s", "ended", OK, "", given())
    async with run() as again:
        for command_id in ("runs", "ended"):
            delivered = await again.deliver_outcome("ann", command_id)
            assert delivered is not None
            assert delivered.is_notified
            assert await again.deliver_outcome("ann", command_id) is None
            former = await found(again, "ann", command_id)
            assert (former.status, former.reason, former.kept) == (delivered.status, delivered.reason, delivered.kept)
        assert await again.deliver_outcome("bob", "runs") is None
    async with run() as last:
        assert await last.deliver_outcome("ann", "runs") is None


async def test_results_that_are_too_long_are_missed_with_a_word(run: MakeJournal) -> None:
    async with run() as journal:
        await journal.accepted("s", "ann", {"one": "robot/lamp"})
        journal.ended("s", "one", OK, "", given("x" * MAX_RESULTS))
    async with run() as again:
        with pytest.raises(ComponentFailed, match="too long"):
            (await found(again, "ann", "one")).results()


async def test_texts_of_clients_may_be_anything(run: MakeJournal) -> None:
    ids = ["\ud800", "'); DROP TABLE command; --", "\0", "\U0001f916" * 1024, "", " "]
    async with run() as journal:
        await journal.accepted("s", "a\0\ud800", dict.fromkeys(ids, "robot/lamp"))
        for command_id in ids:
            journal.ended("s", command_id, ABORT, "no \0 and no \ud800", given("\0\ud800"))
    async with run() as again:
        for command_id in ids:
            assert (await found(again, "a\0\ud800", command_id)).status is ABORT
        assert (journal.failures, journal.lost) == (0, 0)


async def test_of_one_subject_and_id_the_later_command_stands(run: MakeJournal) -> None:
    async with run() as journal:
        await journal.accepted("s", "ann", {"one": "robot/lamp"})
        journal.ended("s", "one", ABORT, "the first", ())
        await journal.accepted("t", "ann", {"one": "robot/voice"})
        await journal.accepted("u", "bob", {"one": "robot/eye"})
    async with run() as again:
        former = await found(again, "ann", "one")
        assert (former.component_ref, former.status) == ("robot/voice", None)
        assert (await found(again, "bob", "one")).component_ref == "robot/eye"


async def test_many_records_are_written_in_their_order(run: MakeJournal) -> None:
    async with run() as journal:
        for number in range(30):
            commands = {f"{number}-{each}": "robot/lamp" for each in range(50)}
            await journal.accepted("s", "ann", commands)
            for command_id in commands:
                journal.ended("s", command_id, OK, "", given(command_id))
    assert (journal.lost, journal.waiting, journal.written) == (0, 0, 3000)
    async with run() as again:
        assert (await found(again, "ann", "29-49")).results() == given("29-49")
        assert (await found(again, "ann", "0-0")).results() == given("0-0")


@pytest.mark.extra(name="base")
async def test_a_gateway_without_a_journal_keeps_nothing_and_waits_for_nothing() -> None:
    journal = NoJournal()
    await journal.accepted("s", "ann", {"one": "robot/lamp"})
    journal.ended("s", "one", OK, "", ())
    journal.engine("robot", is_there=True)
    assert await journal.find("ann", "one") is None
    assert await journal.deliver_outcome("ann", "one") is None
    assert (journal.waiting, journal.written, journal.lost, journal.engines) == (0, 0, 0, frozenset())
