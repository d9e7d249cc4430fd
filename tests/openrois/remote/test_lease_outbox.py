"""Holders of the components of a remote engine: notifications at once, and without room."""

import asyncio
from collections.abc import AsyncIterator, Mapping
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.jsonrpc.outbox import Outbox
from openrois.remote.lease_outbox import LeaseOutbox
from openrois.types.stops import StoppedNotification
from openrois.types.streams import HolderNotification

ANN, BOB = (Client(name, lambda _method, _params: None) for name in ("ann", "bob"))


class OtherSide:
    """A remote engine that reads its notifications when the test lets it."""

    def __init__(self, tasks: TaskScope) -> None:
        self.outbox = Outbox(control_limit=4)
        self.told: list[tuple[str, str, int, bool]] = []
        self.lease_outbox = LeaseOutbox(lambda client: client.client_id, self._notify, self.outbox, tasks)

    def _notify(self, _method: str, params: Mapping[str, Any]) -> None:
        self.told.append((params["component_ref"], params["client_id"], params["epoch"], params["holds"]))

    def take(self, client: Client, epoch: int, *, holds: bool = True, ref: str = "lamp") -> None:
        self.lease_outbox.put_holder(HolderNotification(component_ref=ref, holds=holds, epoch=epoch), client)

    def crowd(self) -> None:
        """Let so much wait that there is no room."""
        while self.outbox.is_roomy:
            self.outbox.put("much")
        self.told.clear()

    async def ease(self) -> list[tuple[str, str, int, bool]]:
        """Read what waits, and return the notifications that follow."""
        assert self.told == []
        while len(self.outbox):
            await self.outbox.get()
        for _ in range(10):
            await asyncio.sleep(0)
        return self.told


@pytest.fixture
async def other() -> AsyncIterator[OtherSide]:
    async with TaskScope() as tasks:
        yield OtherSide(tasks)


async def test_with_room_everything_is_told_at_once(other: OtherSide) -> None:
    other.take(ANN, 1)
    other.take(ANN, 1)
    other.take(ANN, 1, holds=False)
    other.take(BOB, 2)
    other.take(ANN, 1, holds=False)
    lamp = [("lamp", "ann", 1, True), ("lamp", "ann", 1, True), ("lamp", "ann", 1, False), ("lamp", "bob", 2, True)]
    assert other.told == lamp


async def test_in_a_crowd_what_came_and_went_is_not_told(other: OtherSide) -> None:
    other.crowd()
    for epoch in range(1, 1000):
        other.take(ANN, epoch)
        other.take(ANN, epoch, holds=False)
        other.take(ANN, epoch, ref="door")
        other.take(ANN, epoch, ref="door", holds=False)
    other.take(BOB, 1000)
    assert await other.ease() == [("lamp", "bob", 1000, True)]


@pytest.mark.parametrize("client", [ANN, BOB])
async def test_the_former_holders_end_is_notified_before_the_present_holder(other: OtherSide, client: Client) -> None:
    other.take(ANN, 1)
    other.crowd()
    other.take(ANN, 1, holds=False)
    other.take(client, 2)
    assert await other.ease() == [("lamp", "ann", 1, False), ("lamp", client.client_id, 2, True)]
    other.crowd()
    other.take(client, 2, holds=False)
    assert await other.ease() == [("lamp", client.client_id, 2, False)]


async def test_of_an_application_that_is_gone_nothing_is_told(other: OtherSide) -> None:
    other.take(ANN, 1)
    other.crowd()
    other.take(ANN, 1, holds=False)
    other.take(BOB, 2)
    other.lease_outbox.forget_client(BOB, None)
    assert await other.ease() == [("lamp", "ann", 1, False)]
    other.take(ANN, 3)
    other.crowd()
    other.take(ANN, 3, holds=False)
    other.lease_outbox.forget_client(ANN, "ann")
    assert await other.ease() == []


async def test_what_was_handed_on_without_an_end_is_told_as_it_was(other: OtherSide) -> None:
    other.take(ANN, 1)
    other.crowd()
    other.take(BOB, 1)
    assert await other.ease() == [("lamp", "bob", 1, True)]


async def test_what_finds_no_room_waits_for_more(other: OtherSide) -> None:
    other.crowd()
    for number in range(1, 5):
        other.take(ANN, number, ref=f"lamp {number}")
    other.lease_outbox._notify = lambda _method, params: other.outbox.put(str(params["epoch"]))
    assert [await other.outbox.get() for _ in range(2)] == ["much"] * 2
    texts = [await asyncio.wait_for(other.outbox.get(), 60) for _ in range(4)]
    assert texts == ["1", "2", "3", "4"]


async def test_of_each_engine_that_is_stopped_the_latest_is_told_when_there_is_room(other: OtherSide) -> None:
    told: list[tuple[str, str]] = []
    other.lease_outbox._notify = lambda _method, params: told.append((params["engine_id"], params["by"]))

    def stop(engine_id: str, by: str) -> None:
        other.lease_outbox.put_stop(StoppedNotification(engine_id=engine_id, by=by))

    stop("robot", "ann")
    assert told == [("robot", "ann")]
    other.crowd()
    stop("robot", "")
    stop("rover", "ann")
    stop("robot", "bob")
    assert await other.ease() == []
    assert told[1:] == [("robot", "bob"), ("rover", "ann")]
    other.crowd()
    stop("robot", "")
    other.outbox.close()
    other.lease_outbox.clear()
    assert await other.ease() == []
    assert len(told) == 3


async def test_nothing_is_told_when_the_other_side_is_gone(other: OtherSide) -> None:
    other.crowd()
    other.take(ANN, 1)
    other.outbox.close()
    other.lease_outbox.clear()
    assert await other.ease() == []
