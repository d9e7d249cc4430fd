"""Extension calls of many applications over one connection, seen from the parent."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.errors import ComponentFailed
from openrois.jsonrpc.outbox import Outbox, OutboxOverflow
from openrois.remote import extension
from openrois.remote.extension import EXTENSION_NOTIFICATIONS, RemoteExtension
from openrois.types.streams import HolderNotification

OFFER = "signaling.offer"
CONNECT, SUSPEND = "rois.stream.connect_stream", "rois.stream.suspend_stream"


class OtherSide:
    def __init__(self, tasks: TaskScope) -> None:
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.posted: list[tuple[str, dict[str, Any]]] = []
        self.told: list[tuple[str, dict[str, Any]]] = []
        self.answer: Any = {"return_code": "OK"}
        self.too_late: Callable[[Any], None] = lambda _result: None
        self.outbox = Outbox(control_limit=8)
        self.extension = RemoteExtension(
            self._ask,
            lambda name, params: self.posted.append((name, dict(params))),
            self._notify,
            lambda reference: reference.startswith("robot/"),
            self.outbox,
            tasks,
        )

    def _notify(self, name: str, params: Mapping[str, Any]) -> None:
        self.outbox.put(name)
        self.told.append((name, dict(params)))

    async def _ask(
        self, name: str, params: Mapping[str, Any], too_late: Callable[[Any], None], before: Callable[[], None]
    ) -> Any:
        await self.outbox.room()
        before()
        self.asked.append((name, dict(params)))
        self.too_late = too_late
        return self.answer

    def crowd(self) -> None:
        """Let so much wait that there is no room."""
        while self.outbox.is_roomy:
            self.outbox.put("much")

    async def ease(self) -> None:
        """Read what waits."""
        while len(self.outbox):
            await self.outbox.get()
        for _ in range(10):
            await asyncio.sleep(0)

    def tell(self, name: str, **params: Any) -> None:
        self.extension.notifications()[name](params)


class Heard(list[tuple[str, dict[str, Any]]]):
    def client(self, client_id: str) -> Client:
        return Client(client_id, lambda name, params: self.append((name, dict(params))))


@pytest.fixture
async def other() -> AsyncIterator[OtherSide]:
    async with TaskScope() as tasks:
        yield OtherSide(tasks)


async def test_a_call_carries_its_client_and_brings_what_is_told_it(other: OtherSide) -> None:
    ann, bob = Heard(), Heard()
    other.tell(OFFER, client_id="ann", peer_id="robot/0")
    assert await other.extension.call(CONNECT, {"x": 1}, ann.client("ann")) == {"return_code": "OK"}
    await other.extension.call(CONNECT, {}, bob.client("bob"))
    assert other.asked == [(CONNECT, {"x": 1, "client_id": "ann"}), (CONNECT, {"client_id": "bob"})]
    for name in EXTENSION_NOTIFICATIONS:
        other.tell(name, client_id="ann", peer_id="robot/1")
    other.tell(OFFER, client_id="unknown", peer_id="robot/1")
    other.tell(OFFER, peer_id="robot/1")
    other.tell(OFFER, client_id=["ann"], peer_id="robot/1")
    assert ann == [(name, {"peer_id": "robot/1"}) for name in EXTENSION_NOTIFICATIONS]
    assert bob == []


async def test_whether_an_application_may_bind_is_said_to_those_that_want_to_know(other: OtherSide) -> None:
    ann = Heard().client("ann")
    await other.extension.call(CONNECT, {"may_bind": False}, ann)
    other.extension.takes_may_bind = True
    await other.extension.call(CONNECT, {"may_bind": False}, ann)
    assert [params for _, params in other.asked] == [{"client_id": "ann"}, {"client_id": "ann", "may_bind": False}]


@pytest.mark.parametrize("answer", [None, [], "OK", 5])
async def test_an_answer_that_is_no_object(other: OtherSide, answer: Any) -> None:
    other.answer = answer
    with pytest.raises(ComponentFailed):
        await other.extension.call(CONNECT, {}, Heard().client("ann"))


async def test_the_other_side_speaks_for_its_own_alone(other: OtherSide, caplog: pytest.LogCaptureFixture) -> None:
    heard = Heard()
    await other.extension.call(CONNECT, {}, heard.client("ann"))
    with caplog.at_level(logging.INFO):
        for key in ("component_ref", "stream_id", "peer_id"):
            for value in ("other/1", "", 5, None):
                other.tell(OFFER, client_id="ann", **{key: value})
    assert heard == []
    assert len(caplog.records) == 4


async def test_a_client_that_is_gone_is_named_once_and_hears_no_more(other: OtherSide) -> None:
    heard = Heard()
    ann = heard.client("ann")
    await other.extension.forget_client(ann)
    assert other.told == []
    await other.extension.call(CONNECT, {}, ann)
    await other.extension.forget_client(ann)
    await other.extension.forget_client(ann)
    other.tell(OFFER, client_id="ann", peer_id="robot/1")
    assert other.told == [("openrois.client_gone", {"client_id": "ann"})]
    assert heard == []


async def test_an_application_that_comes_back_is_another_client(other: OtherSide) -> None:
    """An application whose way to here was cut is here twice, until what it had before is ended."""
    before, now = Heard(), Heard()
    former, later = before.client("ann"), now.client("ann")
    await other.extension.call(CONNECT, {}, former)
    await other.extension.call(CONNECT, {}, later)
    ids = [params["client_id"] for _, params in other.asked]
    assert ids[0] == "ann"
    assert ids[1] != "ann"
    await other.extension.call(SUSPEND, {}, former)
    await other.extension.call(SUSPEND, {}, later)
    assert [params["client_id"] for _, params in other.asked[2:]] == ids
    await other.extension.forget_client(former)
    assert other.told == [("openrois.client_gone", {"client_id": "ann"})]
    for client_id in ids:
        other.tell(OFFER, client_id=client_id, peer_id="robot/1")
    assert (len(before), len(now)) == (0, 1)
    await other.extension.forget_client(later)
    assert other.told[1:] == [("openrois.client_gone", {"client_id": ids[1]})]


async def test_a_client_without_streams_is_not_kept(other: OtherSide) -> None:
    ann = Heard().client("ann")
    await other.extension.call(SUSPEND, {}, ann)
    assert other.asked == [(SUSPEND, {"client_id": "ann"})]
    await other.extension.forget_client(ann)
    assert other.told == []
    await other.extension.call(CONNECT, {}, Heard().client("ann"))
    await other.extension.call(SUSPEND, {}, ann)
    assert other.asked[2][1]["client_id"] != "ann"


async def test_when_the_other_side_is_gone_no_client_is_notified(other: OtherSide) -> None:
    ann = Heard().client("ann")
    await other.extension.call(CONNECT, {}, ann)
    other.extension.lost()
    await other.extension.forget_client(ann)
    assert other.told == []


@pytest.mark.parametrize(
    ("result", "ended"),
    [
        ({"return_code": "OK", "stream_id": "robot/1"}, ["robot/1"]),
        ({"return_code": "OK", "stream_id": ""}, []),
        ({"return_code": "OK", "stream_id": 5}, []),
        ({"return_code": "OK"}, []),
        (None, []),
    ],
)
async def test_a_stream_that_comes_too_late_is_ended(other: OtherSide, result: Any, ended: list[str]) -> None:
    await other.extension.call(CONNECT, {}, Heard().client("ann"))
    other.too_late(result)
    assert other.posted == [
        ("rois.stream.disconnect_stream", {"stream_id": stream_id, "client_id": "ann"}) for stream_id in ended
    ]


async def test_a_holder_is_notified_and_named_again_in_the_end(other: OtherSide) -> None:
    ann = Heard().client("ann")
    holds = HolderNotification(component_ref="robot/lamp", holds=True, epoch=3)
    ended, held = holds.model_copy(update={"holds": False}), holds.model_dump()
    await other.extension.set_holder(ended, ann)
    assert other.told == []
    await other.extension.set_holder(holds, ann)
    await other.extension.call(SUSPEND, {}, ann)
    await other.extension.set_holder(ended, ann)
    await other.extension.forget_client(ann)
    assert [params["client_id"] for _, params in other.asked] == ["ann"]
    assert other.told == [
        ("openrois.holder", {**held, "client_id": "ann"}),
        ("openrois.holder", {**held, "holds": False, "client_id": "ann"}),
        ("openrois.client_gone", {"client_id": "ann"}),
    ]


async def test_without_room_departed_clients_are_notified_later(other: OtherSide) -> None:
    came = [Heard().client(f"client {number}") for number in range(100)]
    for client in came:
        await other.extension.call(CONNECT, {}, client)
    other.crowd()
    waiting = len(other.outbox)
    for client in came:
        await other.extension.forget_client(client)
    # Half of what may wait is left to what cannot be put off.
    assert (len(other.outbox), other.told) == (waiting, [])
    for _ in range(100):
        await other.ease()
    assert other.told == [("openrois.client_gone", {"client_id": client.client_id}) for client in came]


async def test_without_room_a_client_that_came_and_went_is_not_notified(other: OtherSide) -> None:
    other.crowd()
    for number in range(100):
        client = Heard().client(f"client {number}")
        asking = asyncio.ensure_future(other.extension.call(CONNECT, {}, client))
        await asyncio.sleep(0)
        await other.extension.forget_client(client)
        if number % 2:
            asking.cancel()
    await other.ease()
    assert (other.asked, other.told) == ([], [])


async def test_too_many_departed_clients_end_the_connection(other: OtherSide, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extension, "MAX_GONE", 10)
    came = [Heard().client(f"client {number}") for number in range(100)]
    for client in came:
        await other.extension.call(CONNECT, {}, client)
    other.crowd()
    for client in came[:12]:
        await other.extension.forget_client(client)
    with pytest.raises(OutboxOverflow):
        await asyncio.gather(*map(other.extension.forget_client, came[12:]))
    assert len(other.told) < 10
