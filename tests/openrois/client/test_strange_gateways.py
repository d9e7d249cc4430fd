"""Gateways that say more, less, later or something else than they should, and callers that give up at any moment."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

import pytest

from openrois.client import (
    BindingLost,
    Client,
    Connected,
    ConnectionLost,
    Disconnected,
    ProfileChanged,
    RpcError,
    where,
)
from openrois.client.components import Navigation, VideoStreaming
from openrois.errors import ComponentFailed, Unsupported
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.types.messages import EventNotification
from tests.support.grounds import Clock, Line

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"
HOLD = object()


@dataclass
class Script:
    """A gateway that answers as the test sets, and OK otherwise.

    Attributes:
        answers: by method: the members of the result, or a function of the params that gives them, or HOLD.
        asked: the methods and params that came.
        held: the ids of requests that wait, by method.
        extensions: what it says that it speaks.
    """

    answers: dict[str, Any] = field(default_factory=dict)
    asked: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    held: dict[str, list[int]] = field(default_factory=dict)
    extensions: tuple[str, ...] = ()
    _stream: MessageStream | None = None
    _news: asyncio.Event = field(default_factory=asyncio.Event)

    async def __call__(self, _host: Any, stream: MessageStream) -> None:
        self._stream = stream
        with suppress(StreamClosed):
            while True:
                request = json.loads(await stream.receive())
                method, params = request["method"], request["params"]
                self.asked.append((method, params))
                answer = self.answers.get(method, {})
                if callable(answer):
                    answer = answer(params)
                if method == "openrois.hello":
                    answer = {"extensions": self.extensions}
                if answer is HOLD:
                    self.held.setdefault(method, []).append(request["id"])
                else:
                    await self.say(id=request["id"], result={"return_code": "OK", **answer})
                self._news.set()

    async def say(self, **message: Any) -> None:
        assert self._stream is not None
        await self._stream.send(json.dumps({"jsonrpc": "2.0", **message}))

    async def answer_held(self, method: str, **members: Any) -> None:
        """Answer the first request that waits."""
        await self.say(id=self.held[method].pop(0), result={"return_code": "OK", **members})

    async def until(self, condition: Callable[[], bool]) -> None:
        """Wait until what came makes something hold."""
        while not condition():
            self._news.clear()
            await self._news.wait()

    def times(self, method: str) -> int:
        return [asked for asked, _ in self.asked].count(method)


@pytest.fixture
def script(line: Line) -> Script:
    line.speaks = script = Script()
    return script


async def test_what_a_later_version_says_more_is_passed_over(line: Line, script: Script) -> None:
    result = {"name": "a", "data_type_ref": "int", "value": "1", "unit": "mm"}
    script.answers = {
        "rois.query.query": {"results": [result], "cached": True},
        "rois.event.subscribe": {"subscribe_id": "s"},
    }
    async with Client(dial=line.dial) as client:
        (found,) = await client.query("a")
        assert (found.value, hasattr(found, "unit")) == ("1", False)
        async with client.subscribe("rang") as rang:
            event = {"event_id": "e", "event_type": "rang", "subscribe_id": "s", "results": [result], "priority": 3}
            await script.say(method="rois.event.notify_event", params=event)
            told = await anext(rang)
            assert isinstance(told, EventNotification)
            assert told.results == (found,)
        assert await client.call("other.method") == {"return_code": "OK"}
        script.answers["other.method"] = {"more": {"of": "it"}}
        assert (await client.call("other.method"))["more"] == {"of": "it"}


async def test_a_type_is_found_where_the_gateway_compares_the_code_alone(line: Line, script: Script) -> None:
    def profile(code: str, authority: str) -> dict[str, Any]:
        return {"identifier": {"code": code, "authority": authority}, "name": "x"}

    script.answers = {
        "rois.command.search": {"component_ref_list": []},
        "rois.system.get_profile": {
            "component_profiles": {
                "a/legs": profile("Navigation", "OMG"),
                "b/legs": profile("urn:x-rois:def:component:OMG::Navigation", ""),
                "c/legs": profile("Navigation", "Example"),
                "d/arm": profile("Move", "OMG"),
            }
        },
    }
    async with Client(dial=line.dial) as client:
        found = await client.find_all(Navigation, "component_ref LIKE '%'")
    assert [each.component_ref for each in found] == ["a/legs", "b/legs"]
    assert ("rois.system.get_profile", {"condition": "component_ref LIKE '%'"}) in script.asked


async def test_what_is_wrong_with_an_answer_is_said_in_a_line(line: Line, script: Script) -> None:
    script.answers = {"rois.command.search": {"component_ref_list": ["a", 5]}}
    async with Client(dial=line.dial) as client:
        with pytest.raises(
            RpcError, match=r"^the answer to rois.command.search cannot be read: [^\n]*1[^\n]*string[^\n]*$"
        ):
            await client.search()


async def test_a_client_that_is_cancelled_while_it_takes_leave_is_closed(line: Line, script: Script) -> None:
    script.answers = {"rois.system.disconnect": HOLD}
    before = asyncio.all_tasks()
    client = Client(dial=line.dial)
    await client.__aenter__()
    closing = asyncio.ensure_future(client.__aexit__(None, None, None))
    await script.until(lambda: "rois.system.disconnect" in script.held)
    closing.cancel()
    await asyncio.wait({closing})
    assert client.state.value == "closed"
    await asyncio.sleep(0)
    assert {task for task in asyncio.all_tasks() - before if "client" in repr(task.get_coro())} == set()


async def test_nothing_runs_on_when_the_client_is_closed(line: Line, clock: Clock) -> None:
    before = asyncio.all_tasks()
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as client, client.bound(LAMP):
        listening = await client.component("toys/bell").event("rang").__aenter__()
        notices = client.notices(Disconnected, Connected)
        line.cut()
        await anext(notices)
        await clock.pass_time()
        await anext(notices)
        assert listening is not None
    # What serves the connection belongs to the gateway.
    await asyncio.gather(*line.tasks._tasks)
    assert asyncio.all_tasks() - before == set()


class TestFinding:
    async def test_what_is_waited_for_while_the_client_is_closed(self, line: Line, script: Script) -> None:
        client = Client(dial=line.dial)
        await client.__aenter__()
        finding = asyncio.ensure_future(client.find(Navigation, within=5))
        await script.until(lambda: script.times("rois.command.search") == 1)
        await asyncio.sleep(0)
        await client.__aexit__(None, None, None)
        with pytest.raises(ConnectionLost, match="the client is closed"):
            await finding

    async def test_no_answer_is_not_no_component(self, line: Line, script: Script) -> None:
        async with Client(dial=line.dial, request_timeout=0.05) as client:
            changes = client.notices(ProfileChanged)
            finding = asyncio.ensure_future(client.find(Navigation, within=5))
            await script.until(lambda: script.times("rois.command.search") == 1)
            script.answers = {"rois.command.search": HOLD}
            await script.say(method="rois.system.profile_changed", params={})
            await anext(changes)
            with pytest.raises(TimeoutError, match="no answer within"):
                await finding

    async def test_what_is_found_is_waited_for_until_it_can_be_used(self, line: Line, script: Script) -> None:
        statuses = iter(("UNINITIALIZED", "ERROR", "READY"))
        script.answers = {
            "rois.command.search": {"component_ref_list": ["robot/navigation"]},
            "rois.query.query": lambda _params: {
                "results": [{"name": "status", "data_type_ref": "Component_Status", "value": next(statuses)}]
            },
        }
        async with Client(dial=line.dial) as client:
            found = await client.find(Navigation, within=5)
            assert (found.component_ref, script.times("rois.query.query")) == ("robot/navigation", 3)
            await client.find(Navigation)
            assert script.times("rois.query.query") == 3

    async def test_what_cannot_be_used_in_time_is_returned_as_it_is(self, line: Line, script: Script) -> None:
        status = {"name": "status", "data_type_ref": "Component_Status", "value": "UNINITIALIZED"}
        script.answers = {
            "rois.command.search": {"component_ref_list": ["robot/navigation"]},
            "rois.query.query": {"results": [status]},
        }
        async with Client(dial=line.dial) as client:
            assert (await client.find(Navigation, within=0.01)).component_ref == "robot/navigation"

    async def test_nothing_in_time(self, line: Line, script: Script) -> None:
        async with Client(dial=line.dial) as client:
            with pytest.raises(Unsupported, match="there is no Navigation"):
                await client.find(Navigation, within=0.01)


async def test_a_subscription_that_was_closed_is_over(line: Line, script: Script) -> None:
    script.answers = {"rois.event.subscribe": {"subscribe_id": "s"}}
    async with Client(dial=line.dial) as client:
        never_open = client.subscribe("rang")
        await never_open.close()
        assert [event async for event in never_open] == []
        assert script.times("rois.event.subscribe") == 0
        with pytest.raises(RuntimeError, match="subscribe again"):
            await never_open.__aenter__()


async def test_details_that_cannot_be_read_are_passed_over(line: Line, script: Script) -> None:
    script.answers = {"rois.event.subscribe": {"subscribe_id": "s"}, "rois.event.get_event_detail": {"results": 5}}
    async with Client(dial=line.dial) as client, client.component("toys/bell").event("rang") as rang:
        for event_id, results in (("1", []), ("2", [{"name": "a", "data_type_ref": "int", "value": "1"}])):
            event = {"event_id": event_id, "event_type": "rang", "subscribe_id": "s", "results": results}
            await script.say(method="rois.event.notify_event", params=event)
        assert await anext(rang) == {"a": 1}
        assert rang.unreadable == 1


@pytest.mark.parametrize("strict", [True, False])
async def test_a_stream_status_that_is_none(line: Line, script: Script, strict: bool) -> None:
    script.extensions = () if strict else ("rois.stream",)
    script.answers = {"rois.stream.query_stream_status": {"status": "RUNNING"}}
    async with Client(dial=line.dial) as client:
        with pytest.raises(ComponentFailed if strict else RpcError, match="status"):
            await client.component(VideoStreaming, "robot/camera").get_stream_status("s")


class TestGivingUp:
    """A cancelled caller holds nothing: not if the answer comes later, and not if it comes in the same moment."""

    CASES = pytest.mark.parametrize(
        ("method", "members", "undone"),
        [
            ("rois.command.bind", {}, ("rois.command.release", {"component_ref": LAMP})),
            ("rois.command.bind_any", {"component_ref": LAMP}, ("rois.command.release", {"component_ref": LAMP})),
            ("rois.event.subscribe", {"subscribe_id": "s"}, ("rois.event.unsubscribe", {"subscribe_id": "s"})),
            ("rois.stream.connect_stream", {"stream_id": "t"}, ("rois.stream.disconnect_stream", {"stream_id": "t"})),
        ],
    )

    @staticmethod
    def call(client: Client, method: str) -> Any:
        calls: dict[str, Callable[[], Any]] = {
            "rois.command.bind": lambda: client.bind(LAMP),
            "rois.command.bind_any": client.bind_any,
            "rois.event.subscribe": client.subscribe("rang").__aenter__,
            "rois.stream.connect_stream": client.component(VideoStreaming, "robot/camera").connect_stream,
        }
        return asyncio.ensure_future(calls[method]())

    @CASES
    @pytest.mark.parametrize("late", [True, False])
    async def test_it_is_undone(
        self, line: Line, script: Script, method: str, members: dict[str, str], undone: tuple[str, Any], late: bool
    ) -> None:
        script.answers, script.extensions = {method: HOLD}, ("rois.stream",)
        async with Client(dial=line.dial) as client:
            calling = self.call(client, method)
            await script.until(lambda: method in script.held)
            if late:
                calling.cancel()
                await asyncio.wait({calling})
                await script.answer_held(method, **members)
            else:
                await self._cancel_with_the_answer(calling, client, script, method, members)
            await script.until(lambda: undone in script.asked)
            assert calling.cancelled()
            assert not client._bindings.wants(LAMP)
            assert not client._subscriptions._entries

    @staticmethod
    async def _cancel_with_the_answer(
        calling: "asyncio.Future[Any]", client: Client, script: Script, method: str, members: dict[str, str]
    ) -> None:
        session = client._connection.session("a test")
        settle = session._calls.settle

        def settle_and_cancel(response: Any) -> None:
            settle(response)
            assert calling.cancel()

        session._calls.settle = settle_and_cancel  # type: ignore[method-assign]
        await script.answer_held(method, **members)
        await asyncio.wait({calling})
        session._calls.settle = settle  # type: ignore[method-assign]

    async def test_what_another_caller_binds_meanwhile_stays_bound(self, line: Line, script: Script) -> None:
        script.answers = {"rois.command.bind": HOLD}
        async with Client(dial=line.dial) as client:
            first = self.call(client, "rois.command.bind")
            await script.until(lambda: script.times("rois.command.bind") == 1)
            first.cancel()
            second = self.call(client, "rois.command.bind")
            await script.until(lambda: script.times("rois.command.bind") == 2)
            await script.answer_held("rois.command.bind")
            await script.answer_held("rois.command.bind")
            await second
            await client.search()
            assert script.times("rois.command.release") == 0
            assert client._bindings.wants(LAMP)

    async def test_of_two_that_bind_it_one_may_give_up(self, line: Line, script: Script) -> None:
        async with Client(dial=line.dial) as client:
            await client.bind(LAMP)
            script.answers = {"rois.command.bind": HOLD}
            second = self.call(client, "rois.command.bind")
            await script.until(lambda: script.times("rois.command.bind") == 2)
            await self._cancel_with_the_answer(second, client, script, "rois.command.bind", {})
            await client.search()
            assert script.times("rois.command.release") == 0


class TestConnectingAgain:
    async def test_a_component_that_does_not_answer_does_not_keep_the_connection(
        self, line: Line, clock: Clock, script: Script
    ) -> None:
        """Every bind may take as long as an answer may, all of them at the same time."""
        refs = [f"toys/lamp_{number}" for number in range(50)]
        again = clock.reconnect()
        async with Client(dial=line.dial, connect_timeout=0.05, request_timeout=0.2, reconnect=again) as client:
            for ref in refs:
                await client.bind(ref)
            script.answers = {"rois.command.bind": HOLD}
            notices = client.notices(BindingLost, Connected)
            line.cut()
            await clock.pass_time()
            told = [await anext(notices) for _ in range(len(refs) + 1)]
        assert [type(notice) for notice in told] == [BindingLost] * len(refs) + [Connected]

    async def test_attempts_that_take_long_do_not_count_as_connections(self, line: Line, clock: Clock) -> None:
        @asynccontextmanager
        async def dial() -> AsyncIterator[MessageStream]:
            if line.busy is not None:
                clock.now += 10
            async with line.dial() as stream:
                yield stream

        async with Client(dial=dial, reconnect=clock.reconnect()) as client:
            notices = client.notices(Disconnected)
            line.busy = TimeoutError()
            line.cut()
            waits = [(await anext(notices)).retry_in]
            for _ in range(3):
                await clock.pass_time()
                waits.append((await anext(notices)).retry_in)
        assert waits == pytest.approx([0.5, 0.75, 1.125, 1.6875])

    async def test_a_gateway_that_takes_the_call_and_hangs_up_is_asked_ever_more_seldom(
        self, line: Line, clock: Clock
    ) -> None:
        async with Client(dial=line.dial, reconnect=clock.reconnect()) as client:
            notices = client.notices(Disconnected, Connected)
            waits = []
            for _ in range(5):
                line.cut()
                assert isinstance(await anext(notices), Disconnected)
                waits.append(await clock.pass_time())
                assert isinstance(await anext(notices), Connected)
            assert waits == pytest.approx([0.5, 0.75, 1.125, 1.6875, 2.53125])
            assert await client.search(where(component_ref=LAMP)) == (LAMP,)
