"""Changes of holders are written in the background: the last of each component, also when the store was away."""

import asyncio
import logging
from collections.abc import AsyncIterator, Iterable
from dataclasses import dataclass, field

import pytest

from openrois.errors import StoreUnreachable
from openrois.resumption.holdings_writer import HoldingsWriter
from openrois.resumption.lines import Change, Freed, Held
from openrois.resumption.memory_store import MemoryResumeStore
from tests.support.clock import Clock
from tests.support.ownership import PATIENT

pytestmark = pytest.mark.extra(name="base")


def held(component: str, epoch: int) -> Held:
    return Held(f"robot/{component}", "robot", "line", epoch)


class Store(MemoryResumeStore):
    """A store that is away, or takes as long as a test likes."""

    def __init__(self) -> None:
        super().__init__(Clock())
        self.is_away = False
        self.batches: list[list[Change]] = []
        self.may_go_on = asyncio.Event()
        self.may_go_on.set()
        self.is_writing = asyncio.Event()

    async def write(self, changes: Iterable[Change]) -> None:
        batch = list(changes)
        self.batches.append(batch)
        self.is_writing.set()
        await self.may_go_on.wait()
        if self.is_away:
            raise StoreUnreachable("the store did not answer within 1 s")
        await super().write(batch)


@dataclass
class Stage:
    store: Store = field(default_factory=Store)
    retry: asyncio.Event = field(default_factory=asyncio.Event)
    slept: list[float] = field(default_factory=list)
    asleep: asyncio.Event = field(default_factory=asyncio.Event)

    async def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.asleep.set()
        await self.retry.wait()
        self.retry.clear()


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    async with asyncio.timeout(PATIENT):
        yield Stage()


async def test_what_is_noted_is_in_the_store_soon(stage: Stage) -> None:
    await stage.store.issue("line", 0, "ann", b"one")
    async with HoldingsWriter(stage.store) as writer:
        assert await writer.flushed()
        writer.note(held("lamp", 1))
        writer.note(held("voice", 2))
        assert await writer.flushed(PATIENT)
        assert len(await stage.store.held(["robot"])) == 2
        writer.note(Freed("robot/lamp", 1))
        writer.note(held("voice", 1))
    assert [each.epoch for each in await stage.store.held(["robot"])] == [2]
    assert writer.waiting == 0


async def test_of_each_component_the_last_change_is_written(stage: Stage) -> None:
    async with HoldingsWriter(stage.store) as writer:
        for epoch in range(100):
            writer.note(held("lamp", epoch))
        writer.note(Freed("robot/lamp", 98))
        assert writer.waiting == 1
        assert await writer.flushed(PATIENT)
    assert stage.store.batches == [[held("lamp", 99)]]


async def test_a_change_during_a_write_is_written_after_it(stage: Stage) -> None:
    stage.store.may_go_on.clear()
    async with HoldingsWriter(stage.store) as writer:
        writer.note(held("lamp", 1))
        await stage.store.is_writing.wait()
        writer.note(Freed("robot/lamp", 1))
        assert not await writer.flushed(0)
        stage.store.may_go_on.set()
        assert await writer.flushed(PATIENT)
    assert stage.store.batches == [[held("lamp", 1)], [Freed("robot/lamp", 1)]]


async def test_a_store_that_was_away_learns_how_it_ended(stage: Stage, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    stage.store.is_away = True
    async with HoldingsWriter(stage.store, sleep=stage.sleep) as writer:
        writer.note(held("lamp", 1))
        await stage.asleep.wait()
        stage.asleep.clear()
        writer.note(held("lamp", 2))
        stage.retry.set()
        await stage.asleep.wait()
        assert writer.problem == "the store did not answer within 1 s"
        assert writer.failures == 2
        stage.store.is_away = False
        stage.retry.set()
        assert await writer.flushed(PATIENT)
        assert writer.problem == ""
    assert stage.store.batches[-1] == [held("lamp", 2)]
    assert caplog.messages == [
        "the store did not answer within 1 s; changes of holders wait: a session that is lost now finds less of them",
        "the memory of this gateway takes changes of holders again",
    ]


async def test_of_too_many_changes_the_oldest_is_dropped(stage: Stage, caplog: pytest.LogCaptureFixture) -> None:
    stage.store.may_go_on.clear()
    async with HoldingsWriter(stage.store, most=3) as writer:
        for epoch, component in enumerate("abcdea"):
            writer.note(held(component, epoch))
        assert (writer.waiting, writer.lost) == (3, 3)
        assert len(caplog.messages) == 1
        stage.store.may_go_on.set()
    assert [each.component_ref for each in stage.store.batches[0]] == ["robot/d", "robot/e", "robot/a"]


async def test_a_gateway_that_ends_waits_for_a_moment_and_says_what_is_missing(
    stage: Stage, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage.store.is_away = True
    async with HoldingsWriter(stage.store, sleep=stage.sleep) as writer:
        monkeypatch.setattr(HoldingsWriter.flushed, "__defaults__", (0.01,))
        writer.note(held("lamp", 1))
        await stage.asleep.wait()
    assert caplog.messages[-1] == (
        "1 changes of holders are not in the memory of this gateway: the store did not answer within 1 s"
    )
