"""Bindings and subscriptions are made again after a lost connection; time passes when the test says so."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import suppress
from typing import Any

import pytest

from openrois.client import (
    BindingLost,
    BindingRestored,
    BodyLost,
    Client,
    Connected,
    Disconnected,
    ProfileChanged,
    SubscriptionLost,
    SubscriptionRestored,
    where,
)
from openrois.client.components import Navigation, PersonDetection
from openrois.errors import OutOfResources, Unsupported
from openrois.gateway.applications import serve_application
from openrois.session.change_notice import CHANGES_AT_ONCE
from openrois.session.session import EngineHost
from openrois.transport.stream import MessageStream, StreamClosed
from tests.support.fleet import everything
from tests.support.grounds import Clock, Line, deaf, eventually, heard

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"


@pytest.fixture
async def client(line: Line, clock: Clock) -> AsyncIterator[Client]:
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as connected:
        yield connected


async def test_what_was_bound_is_bound_again(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices()
    navigation = await client.find(Navigation)
    async with navigation.bound():
        line.cut()
        await clock.pass_time()
        assert (await heard(notices, Disconnected, BindingRestored, Connected))[1] == BindingRestored(
            "robot/navigation"
        )
        await navigation.start()
    async with Client(dial=line.dial) as other:
        await other.bind("robot/navigation")


async def test_what_another_has_by_now_is_told_and_bound_again_when_it_is_free(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices()
    await client.bind(LAMP)
    line.cut()
    await heard(notices, Disconnected)
    async with Client(dial=line.dial) as other:
        await other.bind(LAMP)
        await clock.pass_time()
        lost, _ = await heard(notices, BindingLost, Connected)
        assert isinstance(lost, BindingLost)
        assert lost.component_ref == LAMP
        assert isinstance(lost.error, OutOfResources)
        await clock.pass_time()
        await clock.asleep()
    await clock.pass_time()
    await heard(notices, BindingRestored)
    await client.component(LAMP).command("switch", times=1)


async def test_what_is_given_back_meanwhile_is_not_bound_again(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices(Disconnected, Connected)
    async with client.bound(LAMP):
        line.cut()
        await heard(notices, Disconnected)
    await clock.pass_time()
    await heard(notices, Connected)
    async with Client(dial=line.dial) as other:
        await other.bind(LAMP)


async def test_what_is_given_back_while_it_is_bound_again_is_free(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices(Connected)
    await client.bind(LAMP)
    may_answer, asked = asyncio.Event(), asyncio.Event()

    async def slowly(host: EngineHost, stream: MessageStream) -> None:
        await serve_application(host, _Held(stream, "rois.command.bind", asked, may_answer))

    line.speaks = slowly
    line.cut()
    await clock.pass_time()
    await asked.wait()
    await client.release(LAMP)
    may_answer.set()
    await heard(notices, Connected)
    async with Client(dial=line.dial) as other:
        await other.bind(LAMP)


async def test_a_caller_cancelled_at_the_moment_of_binding_holds_nothing(
    line: Line, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with Client(dial=line.dial) as client, Client(dial=line.dial) as other:

        async def hold() -> None:
            async with client.bound(LAMP):
                await asyncio.Event().wait()

        use = client._bindings.use

        def use_and_cancel(component_ref: str) -> None:
            use(component_ref)
            asyncio.get_running_loop().call_soon(holding.cancel)

        monkeypatch.setattr(client._bindings, "use", use_and_cancel)
        holding = asyncio.ensure_future(hold())
        await asyncio.wait({holding})
        assert holding.cancelled()
        await other.bind(LAMP)


async def test_a_caller_cancelled_at_any_moment_holds_nothing(line: Line) -> None:
    async def hold(client: Client) -> None:
        async with client.bound(LAMP):
            await asyncio.Event().wait()

    async with Client(dial=line.dial) as client:
        for turns in range(20):
            holding = asyncio.ensure_future(hold(client))
            for _ in range(turns):
                await asyncio.sleep(0)
            holding.cancel()
            await asyncio.wait({holding})
            # An answer that comes after that is one more question's time away from the release.
            for _ in range(2):
                await client.search()
            assert not line.host.leases.model.holding.held(), turns


class _Held:
    """A stream that keeps requests of one method to itself until it may pass them on."""

    def __init__(self, stream: MessageStream, method: str, asked: asyncio.Event, may_answer: asyncio.Event) -> None:
        self._stream, self._method, self._asked, self._may_answer = stream, method, asked, may_answer
        self.send, self.close, self.abort = stream.send, stream.close, stream.abort

    async def receive(self) -> str:
        text = await self._stream.receive()
        if self._method in text:
            self._asked.set()
            await self._may_answer.wait()
        return text


async def test_iterators_survive_and_count_the_gap(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices()
    persons = await client.find(PersonDetection)
    part = line.robot.parts["PersonDetection"]
    async with persons.person_detected() as detected:
        part.tell("person_detected", number=1)
        await client.search()
        line.cut()
        await heard(notices, Disconnected)
        assert [detected.active, detected.interruptions] == [False, 1]
        part.tell("person_detected", number=2)
        await clock.pass_time()
        _, restored = await heard(notices, Connected, SubscriptionRestored)
        assert restored == SubscriptionRestored("person_detected", where(component_ref="robot/person_detecter"))
        part.tell("person_detected", number=3)
        # Events from before are read; those in between are missing.
        assert [(await anext(detected)).number, (await anext(detected)).number] == [1, 3]
        assert detected.active


async def test_a_component_that_is_gone_is_told_and_heard_again_when_it_is_back(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices()
    async with client.component("toys/bell").event("rang") as rang:
        await client.bind(LAMP)
        line.host.engine.detach(line.toys)
        found = await heard(notices, ProfileChanged, BindingLost, SubscriptionLost)
        assert isinstance(found[2], SubscriptionLost)
        assert isinstance(found[2].error, Unsupported)
        assert [rang.active, rang.interruptions] == [False, 1]
        await line.host.engine.attach(line.toys)
        await heard(notices, ProfileChanged, BindingRestored, SubscriptionRestored)
        line.bell.ring("again")
        assert await anext(rang) == {"tune": "again"}


async def test_renewing_loses_no_event_and_repeats_none(line: Line, client: Client) -> None:
    changes = client.notices(ProfileChanged, buffer=1000)
    async with client.component("toys/bell").event("rang", buffer=1000) as rang:
        for number in range(300):
            line.bell.ring(str(number))
            if number % (300 // CHANGES_AT_ONCE) == 0:
                # Whatever changes in the tree, every subscription is made again beside the old one.
                await line.host.engine.attach(everything(f"robot_{number}").registry)
            await asyncio.sleep(0)
        for _ in range(CHANGES_AT_ONCE):
            await anext(changes)
        assert [(await anext(rang))["tune"] for _ in range(300)] == [str(number) for number in range(300)]
        line.bell.ring("the end")
        assert await anext(rang) == {"tune": "the end"}
        assert [rang.dropped, rang.interruptions] == [0, 0]
        await eventually(client, lambda: len(line.host.engine._subscriptions) == 1)


async def test_an_event_that_comes_by_the_old_and_the_new_subscription_is_heard_once(line: Line) -> None:
    unsubscribed: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    async def speak(_host: Any, stream: MessageStream) -> None:
        async def tell(method: str, **params: Any) -> None:
            await stream.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": params}))

        async def ring(event_id: str, subscribe_id: str) -> None:
            tune = [{"name": "tune", "data_type_ref": "string", "value": event_id}]
            about = {"event_id": event_id, "event_type": "rang", "subscribe_id": subscribe_id}
            await tell("rois.event.notify_event", **about, results=tune)

        subscribe_ids = iter(("old", "new"))
        with suppress(StreamClosed):
            while True:
                request = json.loads(await stream.receive())
                result = {"return_code": "OK"}
                if request["method"] == "rois.event.unsubscribe" and not unsubscribed.done():
                    unsubscribed.set_result(request["params"])
                if request["method"] != "rois.event.subscribe":
                    await stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}))
                    continue
                subscribe_id = next(subscribe_ids)
                if subscribe_id == "new":
                    await ring("while it is renewed", "old")
                result["subscribe_id"] = subscribe_id
                await stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}))
                if subscribe_id == "old":
                    await ring("before", "old")
                    await tell("rois.system.profile_changed")
                else:
                    await ring("while it is renewed", "new")
                    await ring("afterwards", "old")
                    await ring("afterwards", "new")

    line.speaks = speak
    async with (
        asyncio.timeout(60),
        Client(dial=line.dial) as client,
        client.component("toys/bell").event("rang") as rang,
    ):
        tunes = [(await anext(rang))["tune"] for _ in range(3)]
        assert tunes == ["before", "while it is renewed", "afterwards"]
        assert await unsubscribed == {"subscribe_id": "old"}


async def test_an_abandoned_subscription_is_not_made_again(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices()
    async with client.component("toys/bell").event("rang"):
        line.cut()
        await heard(notices, Disconnected)
    await clock.pass_time()
    await heard(notices, Connected)
    await eventually(client, lambda: not line.host.engine._subscriptions)


async def test_a_connection_that_ends_while_unsubscribing_ends_the_subscription_too(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices(Connected)
    rang = await client.component("toys/bell").event("rang").__aenter__()
    async with deaf(line):
        ending = asyncio.ensure_future(rang.close())
        line.cut()
        await ending
        await clock.pass_time()
        await heard(notices, Connected)
    assert not client._subscriptions._entries
    assert [event async for event in rang] == []


async def test_of_a_body_that_is_lost_while_it_is_bound_again_nothing_stays_held(
    line: Line, clock: Clock, client: Client
) -> None:
    gone, lost = client.notices(Disconnected), client.notices(BodyLost)
    async with client.body("Move", "Navigation"):
        line.cut()
        await heard(gone, Disconnected)
        async with Client(dial=line.dial) as other:
            await other.bind("robot/navigation")
            await clock.pass_time()
            # The first of the two was bound again when the second was refused.
            await heard(lost, BodyLost)
            await client.search()
            await other.bind("robot/move")
