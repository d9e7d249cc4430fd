"""A connection that ends is made again, with what was bound and subscribed; time passes when the test says so."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

import pytest

from openrois.client import (
    BindingLost,
    BindingRestored,
    Client,
    Connected,
    ConnectionFailed,
    ConnectionLost,
    ConnectionState,
    Disconnected,
    Notice,
    ProfileChanged,
    Reconnect,
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
from tests.support.grounds import Clock, Line, eventually

LAMP = "toys/lamp"


@pytest.fixture
async def client(line: Line, clock: Clock) -> AsyncIterator[Client]:
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as connected:
        yield connected


async def heard(notices: AsyncIterator[Any], *kinds: type[Notice]) -> list[Notice]:
    """Return the next notices, which are of these kinds."""
    async with asyncio.timeout(60):
        found = [await anext(notices) for _ in kinds]
    assert [type(each) for each in found] == list(kinds)
    return found


async def test_a_lost_connection_is_made_again_and_the_application_is_told(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices()
    line.cut()
    assert await heard(notices, Disconnected) == [Disconnected("closed with 1006", 0.5)]
    assert client.state.value == "waiting"
    assert await clock.pass_time() == 0.5
    await heard(notices, Connected)
    assert client.state.value == "connected"
    assert await client.search(where(component_ref=LAMP)) == (LAMP,)


async def test_waits_grow_while_nobody_answers_and_start_over_after_a_connection_that_lasted(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices()
    line.busy = OSError("nobody is there")
    clock.now += 60
    line.cut()
    assert [await clock.pass_time() for _ in range(10)][:4] == pytest.approx([0.5, 0.75, 1.125, 1.6875])
    assert clock.asked[-1] == 10
    line.busy = None
    while not isinstance(await anext(notices), Connected):
        pass
    clock.now += 60
    line.cut()
    assert await clock.pass_time() == 0.5


def test_clients_do_not_come_back_all_at_once() -> None:
    chances = iter((0.0, 0.5, 1.0))
    by_chance = Reconnect(random=lambda: next(chances))
    assert [by_chance.spread(2.0) for _ in range(3)] == [0.0, 1.0, 2.0]
    assert len({Reconnect().spread(1.0) for _ in range(100)}) > 50


@pytest.mark.parametrize("code", [1001, 1012, 1013])
async def test_whatever_the_gateway_ends_it_with_it_is_dialled_again(
    line: Line, clock: Clock, client: Client, code: int
) -> None:
    notices = client.notices(Disconnected, Connected)
    await line.hang_up(code, "retry_after=7")
    (told,) = await heard(notices, Disconnected)
    assert told == Disconnected(f"closed with {code} retry_after=7", 7.5)
    assert await clock.pass_time() == 7.5
    await heard(notices, Connected)


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


async def test_whoever_is_cancelled_at_the_moment_of_binding_holds_nothing(
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
        # What came before is read; what happened in between was heard by nobody.
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


async def test_a_subscription_that_nobody_wants_any_more_is_not_made_again(
    line: Line, clock: Clock, client: Client
) -> None:
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


async def test_commands_that_ran_are_lost_and_say_so_once(line: Line, clock: Clock, client: Client) -> None:
    lamp = client.component(LAMP)
    await lamp.bind()
    running = await client.execute(lamp.command("start"), lamp.command("switch", times=1))
    await line.lamp.glowing.wait()
    line.cut()
    await clock.asleep()
    assert [command.done for command in running.commands] == [False, False]
    await clock.pass_time()
    with pytest.raises(ConnectionLost, match=r"start of toys/lamp: the connection ended.*does not know of it"):
        await running
    assert [command.done for command in running.commands] == [True, True]
    line.lamp.may_end.set()
    await client.search()
    with pytest.raises(ConnectionLost):
        await running.commands[1]


async def test_commands_are_not_kept_for_later(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices(Disconnected)
    lamp = client.component(LAMP)
    await lamp.bind()
    line.cut()
    await heard(notices, Disconnected)
    for acting in (client.call("rois.system.connect"), lamp.command("switch", times=1)):
        with pytest.raises(ConnectionLost, match="what acts is not kept for later"):
            await acting
    assert line.lamp.total == 0


async def test_a_command_that_still_asks_for_its_profile_is_not_kept_either(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices(Connected)
    async with deaf(line) as asked:
        line.cut()
        await clock.pass_time()
        await heard(notices, Connected)
        acting = asyncio.ensure_future(client.component(LAMP).command("switch", times=1).execute())
        await asked("rois.system.get_profile")
    line.cut()
    await clock.pass_time()
    with pytest.raises(ConnectionLost, match=r"rois.command.execute: the connection ended"):
        await acting
    assert line.lamp.total == 0


async def test_questions_wait_for_the_connection(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices(Disconnected)
    line.cut()
    await heard(notices, Disconnected)
    asking = [asyncio.ensure_future(client.search(where(component_ref=LAMP))) for _ in range(3)]
    binding = asyncio.ensure_future(client.bind(LAMP))
    await clock.pass_time()
    assert await asyncio.gather(*asking) == [(LAMP,)] * 3
    await binding
    assert await client.component(LAMP).command("switch", times=1) == {"total": 1}


async def test_questions_do_not_wait_for_ever(line: Line, clock: Clock) -> None:
    async with Client(dial=line.dial, reconnect=clock.reconnect(), request_timeout=0.05) as client:
        notices = client.notices(Disconnected)
        line.cut()
        await heard(notices, Disconnected)
        with pytest.raises(TimeoutError, match=r"rois.command.search: no answer within 0.05 s"):
            await client.search()


async def test_a_question_that_was_on_its_way_is_asked_again(line: Line, clock: Clock, client: Client) -> None:
    notices = client.notices(Connected)
    async with deaf(line) as asked:
        line.cut()
        await clock.pass_time()
        await heard(notices, Connected)
        searching = asyncio.ensure_future(client.search(where(component_ref=LAMP)))
        acting = asyncio.ensure_future(client.call("rois.command.release", component_ref=LAMP))
        await asked("rois.command.search")
        await asked("rois.command.release")
    line.cut()
    with pytest.raises(ConnectionLost, match=r"rois.command.release: the connection ended before the answer came"):
        await acting
    await clock.pass_time()
    assert await searching == (LAMP,)


@asynccontextmanager
async def deaf(line: Line) -> AsyncIterator[Any]:
    """Let the gateway answer nothing but the greeting; yields a wait for a method to be asked."""
    asked: dict[str, asyncio.Event] = {}
    usual = line.speaks

    async def speak(_host: Any, stream: MessageStream) -> None:
        while True:
            try:
                message = json.loads(await stream.receive())
            except StreamClosed:
                return
            result = {"return_code": "OK"}
            if message["method"] in ("rois.system.connect", "openrois.hello", "rois.system.disconnect"):
                await stream.send(json.dumps({"jsonrpc": "2.0", "id": message["id"], "result": result}))
            asked.setdefault(message["method"], asyncio.Event()).set()

    async def wait_for(method: str) -> None:
        async with asyncio.timeout(60):
            await asked.setdefault(method, asyncio.Event()).wait()

    line.speaks = speak
    try:
        yield wait_for
    finally:
        line.speaks = usual


async def test_without_reconnecting_a_lost_connection_is_the_end(line: Line) -> None:
    async with Client(dial=line.dial, reconnect=None) as client:
        notices = client.notices()
        rang = await client.component("toys/bell").event("rang").__aenter__()
        line.cut()
        await heard(notices, Disconnected)
        for asking in (client.search(), anext(rang), anext(notices), client.call("rois.system.connect")):
            with pytest.raises(ConnectionLost, match="the connection ended: closed with 1006"):
                await asking
        assert client.state is ConnectionState.CLOSED
    assert line.dialled == 1


@pytest.mark.parametrize(
    "end",
    [ConnectionFailed("it answered 401", final=True), StreamClosed(4401, "the token has ended")],
    ids=["refused", "ended"],
)
async def test_a_gateway_that_does_not_let_it_in_is_not_asked_again(
    line: Line, clock: Clock, client: Client, end: Exception
) -> None:
    notices = client.notices(Disconnected)
    if isinstance(end, StreamClosed):
        await line.hang_up(end.code, end.reason)
    else:
        line.busy = end
        line.cut()
        await clock.pass_time()
        await heard(notices, Disconnected)
    (told,) = await heard(notices, Disconnected)
    assert isinstance(told, Disconnected)
    assert told.retry_in is None
    with pytest.raises(ConnectionLost):
        await client.search()


async def test_a_failure_of_the_client_itself_ends_it_with_a_word(
    line: Line, clock: Clock, client: Client, caplog: pytest.LogCaptureFixture
) -> None:
    line.busy = ZeroDivisionError("a bug in dial")
    line.cut()
    await clock.pass_time()
    with pytest.raises(ConnectionLost, match="a bug in dial"):
        await client.search()
    assert "the connection could not be kept" in caplog.text


async def test_closing_does_not_wait_for_the_next_attempt(line: Line, clock: Clock) -> None:
    async with asyncio.timeout(60):
        async with Client(dial=line.dial, reconnect=clock.reconnect()) as client:
            notices = client.notices()
            waiting = asyncio.ensure_future(client.search())
            await waiting
            line.busy = OSError("nobody is there")
            line.cut()
            await heard(notices, Disconnected)
            waiting = asyncio.ensure_future(client.search())
            await asyncio.sleep(0)
        with pytest.raises(ConnectionLost, match="the client is closed"):
            await waiting
        assert [type(each) async for each in notices] == [Disconnected]


async def test_a_client_is_used_once(line: Line) -> None:
    client = Client(dial=line.dial)
    async with client:
        with pytest.raises(RuntimeError, match="make another one"):
            await client.__aenter__()
        assert await client.search(where(component_ref=LAMP)) == (LAMP,)
    with pytest.raises(RuntimeError, match="make another one"):
        await client.__aenter__()


async def test_the_first_connection_is_not_tried_again(line: Line, clock: Clock) -> None:
    line.busy = OSError("nobody is there")
    with pytest.raises(ConnectionFailed, match="no connection to the gateway: nobody is there"):
        async with Client(dial=line.dial, reconnect=clock.reconnect()):
            pass
    assert [line.dialled, clock.asked] == [1, []]


async def test_a_gateway_that_says_nothing_is_given_up(line: Line) -> None:
    async def silent(_host: Any, stream: MessageStream) -> None:
        try:
            while True:
                await stream.receive()
        except StreamClosed:
            return

    line.speaks = silent
    with pytest.raises(ConnectionFailed, match=r"the gateway did not answer within 0.05 s"):
        async with Client(dial=line.dial, connect_timeout=0.05):
            pass


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ({"result": {"return_code": "ERROR"}}, "rois.system.connect: ERROR"),
        ({"result": {"return_code": "MAYBE"}}, "the answer to rois.system.connect cannot be read"),
        ({"error": {"code": -32603, "message": "Internal error"}}, r"no connection .*: Internal error \(-32603\)"),
        ({"error": {"code": -32601, "message": "Method not found"}}, r"what answers does not serve applications: rois"),
    ],
)
async def test_a_gateway_that_refuses_the_greeting_is_no_gateway(line: Line, answer: Any, reason: str) -> None:
    async def refuse(_host: Any, stream: MessageStream) -> None:
        request = json.loads(await stream.receive())
        await stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], **answer}))

    line.speaks = refuse
    with pytest.raises(ConnectionFailed, match=reason):
        async with Client(dial=line.dial):
            pass


async def test_a_gateway_that_fails_at_hello_is_no_gateway(line: Line) -> None:
    async def fail(_host: Any, stream: MessageStream) -> None:
        for answer in ({"result": {"return_code": "OK"}}, {"error": {"code": -32603, "message": "Internal error"}}):
            request = json.loads(await stream.receive())
            await stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], **answer}))

    line.speaks = fail
    with pytest.raises(ConnectionFailed, match=r"Internal error \(-32603\)"):
        async with Client(dial=line.dial):
            pass


@pytest.mark.parametrize(
    ("method", "result", "undone"),
    [
        ("rois.command.bind", {}, ("rois.command.release", {"component_ref": LAMP})),
        ("rois.command.bind_any", {"component_ref": LAMP}, ("rois.command.release", {"component_ref": LAMP})),
        ("rois.event.subscribe", {"subscribe_id": "s1"}, ("rois.event.unsubscribe", {"subscribe_id": "s1"})),
    ],
)
async def test_what_comes_when_nobody_waits_for_it_is_undone(
    line: Line, method: str, result: dict[str, Any], undone: tuple[str, dict[str, Any]]
) -> None:
    undoing: asyncio.Future[tuple[str, Any]] = asyncio.get_running_loop().create_future()
    given_up = asyncio.Event()

    async def slow(_host: Any, stream: MessageStream) -> None:
        try:
            while True:
                request = json.loads(await stream.receive())
                answer = {"return_code": "OK"}
                if request["method"] == method:
                    await given_up.wait()
                    answer |= result
                elif request["method"] == undone[0]:
                    undoing.set_result((request["method"], request["params"]))
                await stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": answer}))
        except StreamClosed:
            return

    line.speaks = slow
    async with Client(dial=line.dial, request_timeout=0.05) as client:
        calls: dict[str, Callable[[], Awaitable[Any]]] = {
            "rois.command.bind": lambda: client.bind(LAMP),
            "rois.command.bind_any": client.bind_any,
            "rois.event.subscribe": lambda: client.subscribe("rang").__aenter__(),
        }
        with pytest.raises(TimeoutError):
            await calls[method]()
        given_up.set()
        async with asyncio.timeout(60):
            assert await undoing == undone
