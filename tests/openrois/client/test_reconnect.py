"""A connection that ends is made again, or not; commands and requests meanwhile; time passes when the test says so."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any

import pytest

from openrois.client import (
    Client,
    Connected,
    ConnectionFailed,
    ConnectionLost,
    ConnectionState,
    Disconnected,
    Reconnect,
    where,
)
from openrois.transport.stream import MessageStream, StreamClosed
from tests.support.grounds import Clock, Line, deaf, heard

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"


@pytest.fixture
async def client(line: Line, clock: Clock) -> AsyncIterator[Client]:
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as connected:
        yield connected


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


async def test_waits_grow_without_a_gateway_and_start_over_after_a_connection_that_lasted(
    line: Line, clock: Clock, client: Client
) -> None:
    notices = client.notices()
    line.busy = OSError("no gateway is there")
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
        with pytest.raises(ConnectionLost, match="commands are not kept for later"):
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
            line.busy = OSError("no gateway is there")
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
    line.busy = OSError("no gateway is there")
    with pytest.raises(ConnectionFailed, match="no connection to the gateway: no gateway is there"):
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
async def test_a_late_result_without_caller_is_undone(
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
