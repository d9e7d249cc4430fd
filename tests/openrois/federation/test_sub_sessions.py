"""Sessions of an application at other gateways, over streams in memory to what a test lets answer there."""

import asyncio
import json
from collections.abc import AsyncIterator, Mapping
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import LOCAL
from openrois.errors import ComponentFailed, EngineUnreachable, NotResponding, Unsupported
from openrois.federation.assertion import Assertion
from openrois.federation.counts import Counts
from openrois.federation.sub_session import MAX_REFS, SubSession
from openrois.federation.sub_sessions import SubSessions
from openrois.jsonrpc.session import InvalidParams
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.transport.stream import MessageStream, StreamClosed
from tests.support.deployment import patience


class Far:
    """Another gateway, and the sessions at it."""

    def __init__(self, tasks: TaskScope) -> None:
        self.dialled: list[tuple[str, Assertion]] = []
        self.streams: list[MemoryStream] = []
        self.refusal: EngineUnreachable | None = None
        self.told: list[tuple[str, Any]] = []
        self.lost: list[tuple[str, StreamClosed]] = []
        self.shown: set[str] = set()
        self.is_lost = asyncio.Event()
        self.is_told = asyncio.Event()
        self.counts = Counts()
        self.subs = SubSessions(
            self.dial, tasks, lambda: Assertion.of(LOCAL), self.notify, self.see, self.lose, self.counts
        )

    async def dial(self, gateway_id: str, assertion: Assertion) -> MessageStream:
        self.dialled.append((gateway_id, assertion))
        if self.refusal is not None:
            raise self.refusal
        near, far = memory_pair()
        self.streams.append(far)
        return near

    def notify(self, method: str, params: Any, **_more: bool) -> None:
        self.told.append((method, params))
        self.is_told.set()

    def see(self, _gateway_id: str, method: str, _params: Mapping[str, Any]) -> bool:
        return method not in self.shown

    def lose(self, sub: SubSession, closed: StreamClosed) -> None:
        self.lost.append((sub.gateway_id, closed))
        self.is_lost.set()

    async def asked(self) -> dict[str, Any]:
        """Return the next message to the last session."""
        async with patience():
            message: dict[str, Any] = json.loads(await self.streams[-1].receive())
        return message

    async def say(self, *messages: dict[str, Any]) -> None:
        for message in messages:
            await self.streams[-1].send(json.dumps({"jsonrpc": "2.0", **message}))


@pytest.fixture
async def far() -> AsyncIterator[Far]:
    async with TaskScope() as tasks:
        yield Far(tasks)


async def relayed(far: Far, *answers: dict[str, Any], method: str = "rois.command.bind") -> Any:
    """Ask something over a session, have it answered, and return the reply."""
    sub = await far.subs.to("a")
    asking = asyncio.ensure_future(sub.relay(method, {}))
    request = await far.asked()
    await far.say(*({"id": request["id"], **answer} if "method" not in answer else answer for answer in answers))
    async with patience():
        return await asking


EVENT = {"method": "rois.event.notify_event", "params": {"event_id": "e"}}
OK = {"result": {"return_code": "OK"}}


class TestASession:
    async def test_a_reply_leaves_before_what_was_notified_behind_it(self, far: Far) -> None:
        reply = await relayed(far, OK, EVENT)
        await far.say(EVENT)
        for _ in range(5):
            await asyncio.sleep(0)
        assert far.told == []
        reply.then()
        assert far.told == [(EVENT["method"], EVENT["params"])] * 2

    async def test_a_reason_waits_for_what_it_explains(self, far: Far) -> None:
        await far.subs.to("a")
        reason = {"command_id": "1", "reason": "it was stopped"}
        await far.say({"method": "openrois.reason", "params": reason})
        await far.say({"method": "openrois.ping", "params": {}, "id": 7})
        assert (await far.asked())["id"] == 7, "the reason was read"
        assert far.told == []
        completed = {"command_id": "1", "status": "ABORT"}
        await far.say({"method": "rois.command.completed", "params": completed})
        async with patience():
            await far.is_told.wait()
        assert far.told == [("openrois.reason", reason), ("rois.command.completed", completed)]

    async def test_a_reason_is_that_of_its_reply(self, far: Far) -> None:
        sub = await far.subs.to("a")
        asking = asyncio.ensure_future(sub.relay("rois.command.bind", {}))
        number = (await far.asked())["id"]
        await far.say(
            {"method": "openrois.reason", "params": {"request_id": number, "reason": "it is bound"}},
            {"id": number, "result": {"return_code": "OUT_OF_RESOURCES"}},
        )
        reply = await asking
        assert (reply.result, reply.reason) == ({"return_code": "OUT_OF_RESOURCES"}, "it is bound")
        assert far.told == []

    async def test_what_the_application_has_of_its_own_gateway_goes_no_further(self, far: Far) -> None:
        far.shown.add("rois.command.completed")
        await far.subs.to("a")
        await far.say(
            {"method": "rois.system.profile_changed", "params": {}},
            {"method": "openrois.directory.changed", "params": {}},
            {"method": "rois.command.completed", "params": {"command_id": "1"}},
            EVENT,
        )
        async with patience():
            await far.is_told.wait()
        assert far.told == [(EVENT["method"], EVENT["params"])]

    async def test_what_a_newer_gateway_says_besides_goes_on_or_is_passed_over(self, far: Far) -> None:
        refused = {"result": {"return_code": "ERROR", "more": {"of": "it"}}}
        sub = await far.subs.to("a")
        asking = asyncio.ensure_future(sub.relay("rois.command.bind", {}))
        request_id = (await far.asked())["id"]
        why = {"request_id": request_id, "reason": "it sleeps", "more": 1}
        await far.say({"method": "openrois.reason", "params": why}, {"id": request_id, **refused})
        reply = await asking
        assert (reply.reason, reply.result) == ("it sleeps", refused["result"])

    async def test_errors_are_the_applications_own_or_the_gateways(self, far: Far) -> None:
        wrong = {"error": {"code": -32602, "message": "no", "data": [{"path": "x", "message": "is missing"}]}}
        with pytest.raises(InvalidParams, match="x: is missing"):
            await relayed(far, wrong)
        with pytest.raises(ComponentFailed, match=r"gateway a refused rois\.command\.bind with the error -32603"):
            await relayed(far, {"error": {"code": -32603, "message": "no"}})
        with pytest.raises(Unsupported, match=r"gateway a is of an older version, without rois\.command\.bind"):
            await relayed(far, {"error": {"code": -32601, "message": "Method not found: rois.command.bind"}})
        sub = await far.subs.to("a")
        asking = asyncio.ensure_future(sub.ask("openrois.stop_all", {}))
        await far.say({"id": (await far.asked())["id"], "result": 7})
        with pytest.raises(ComponentFailed, match=r"answers openrois\.stop_all with what is no object"):
            await asking
        counted = {"answered": 2, "refused": 2, "late": 0, "lost": 0, "unreached": 0}
        assert far.counts.calls == counted

    async def test_a_gateway_that_does_not_answer_is_left(self, far: Far) -> None:
        sub = await far.subs.to("a")
        with pytest.raises(NotResponding, match=r"gateway a did not answer openrois\.stop_all in time"):
            await sub.ask("openrois.stop_all", {}, timeout=0)
        assert far.counts.calls["late"] == 1

    async def test_components_and_engines_are_remembered_up_to_a_bound(self, far: Far) -> None:
        sub = await far.subs.to("a")
        for number in range(MAX_REFS + 2):
            sub.note_ref(f"robot/{number}")
        assert len(sub.refs) == MAX_REFS
        assert "robot/1" not in sub.refs


class TestSessions:
    async def test_one_is_opened_for_all_that_need_it_and_begins_with_what_has_to_be_said(self, far: Far) -> None:
        await far.subs.say("openrois.hello", {"version": "1"})
        one, other = await asyncio.gather(far.subs.to("a"), far.subs.to("a"))
        assert one is other
        assert [gateway_id for gateway_id, _ in far.dialled] == ["a"]
        assert (await far.asked())["params"] == {"version": "1"}
        saying = asyncio.ensure_future(far.subs.say("rois.system.connect", {}))
        request = await far.asked()
        assert request["method"] == "rois.system.connect"
        await far.say({"id": request["id"], "result": {"return_code": "OK"}})
        await saying
        assert far.subs.says("rois.system.connect")
        far.subs.unsay("rois.system.connect")
        assert not far.subs.says("rois.system.connect")

    async def test_a_refusal_is_that_of_all_who_wait_and_the_next_tries_again(self, far: Far) -> None:
        far.refusal = EngineUnreachable("gateway 'a' is not reached")
        outcomes = await asyncio.gather(far.subs.to("a"), far.subs.to("a"), return_exceptions=True)
        assert [str(each) for each in outcomes] == ["gateway 'a' is not reached"] * 2
        far.refusal = None
        await far.subs.to("a")

    async def test_a_lost_one_fails_what_waits_and_is_told_once(self, far: Far) -> None:
        sub = await far.subs.to("a")
        asking = asyncio.ensure_future(sub.relay("rois.command.bind", {}))
        await far.asked()
        far.streams[-1].abort()
        with pytest.raises(EngineUnreachable, match="gateway a, which has the engine, was lost"):
            await asking
        assert far.counts.calls["lost"] == 1
        async with patience():
            await far.is_lost.wait()
        assert [gateway_id for gateway_id, _ in far.lost] == ["a"]
        assert await far.subs.to("a") is not sub

    @pytest.mark.parametrize(("lost", "code"), [(False, 1000), (True, 1011)])
    async def test_they_end_as_the_connection_of_the_application_did(self, far: Far, lost: bool, code: int) -> None:
        await far.subs.to("a")
        await far.subs.close(lost=lost)
        with pytest.raises(StreamClosed) as ended:
            await far.streams[-1].receive()
        assert ended.value.code == code
        assert far.lost == [], "the application has left, so that nothing is told"


async def test_what_is_said_to_all_gateways_has_been_heard_when_it_returns(far: Far) -> None:
    await far.subs.to("a")
    saying = asyncio.ensure_future(far.subs.say("openrois.hello", {"version": "1"}))
    request = await far.asked()
    assert (request["method"], saying.done()) == ("openrois.hello", False)
    await far.say({"id": request["id"], "result": {"return_code": "OK"}})
    async with patience():
        await saying
    # What is lost meanwhile is waited for no more.
    saying = asyncio.ensure_future(far.subs.say("openrois.hello", {"version": "1"}))
    await far.asked()
    await far.streams[-1].close()
    async with patience():
        await saying
