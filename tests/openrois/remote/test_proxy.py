"""The proxy of a remote engine, against a session whose other end is played by hand."""

import asyncio
import gc
import json
from collections.abc import AsyncIterator
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.contract import Client, Event, SubscriptionLost
from openrois.errors import Aborted, ComponentFailed, EngineUnreachable, NotResponding, TimedOut, Unsupported
from openrois.jsonrpc.outbox import CONTROL_LIMIT
from openrois.jsonrpc.session import RpcSession
from openrois.remote.proxy import RemoteProxy
from openrois.remote.remote_offer import READS, Identity
from openrois.transport.memory import MemoryStream, memory_pair
from tests.support.plain import profile_result

TOY = "plain/toy"


class Far:
    """The remote engine, by hand: reads a request, answers it as the test sets."""

    def __init__(self, stream: MemoryStream, proxy: RemoteProxy, session: RpcSession) -> None:
        self.stream = stream
        self.proxy = proxy
        self.session = session
        self.changes = 0

    async def asked(self, method: str) -> dict[str, Any]:
        async with asyncio.timeout(60):
            request: dict[str, Any] = json.loads(await self.stream.receive())
        assert request["method"] == method
        return request

    async def answer(self, request: dict[str, Any], **result: Any) -> None:
        message = {"jsonrpc": "2.0", "id": request["id"], "result": {"return_code": "OK", **result}}
        await self.stream.send(json.dumps(message))

    async def tell(self, method: str, **params: Any) -> None:
        await self.stream.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": params}))

    async def introduce(
        self,
        *,
        plain: bool = False,
        extensions: tuple[str, ...] = ("rois.stream",),
        engines: tuple[str, ...] = (),
        timeout: int | None = None,
        **who: Any,
    ) -> None:
        """Answer what `discover` asks; `timeout` is that of the command `start`, `who` more of the answer to hello."""
        discovering = asyncio.ensure_future(self.proxy.discover())
        profile = profile_result("toy")
        profile["component_profiles"][TOY]["command_profiles"][0]["timeout"] = timeout
        await self.answer(await self.asked("rois.system.get_profile"), **profile)
        if plain:
            error = {"code": -32601, "message": "Method not found"}
            request = await self.asked("openrois.hello")
            await self.stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "error": error}))
        else:
            hello = {"version": "1", "extensions": list(extensions), "engines": list(engines), "client_id": "", **who}
            await self.answer(await self.asked("openrois.hello"), **hello)
        await discovering


@pytest.fixture
async def far() -> AsyncIterator[Far]:
    near, stream = memory_pair()
    session = RpcSession(near)
    made: Far

    def changed() -> None:
        made.changes += 1

    async with TaskScope() as tasks:
        proxy = RemoteProxy(session, changed, tasks)
        made = Far(stream, proxy, session)
        session.notifications = proxy.notifications()
        running = asyncio.ensure_future(session.run())
        running.add_done_callback(lambda _task: proxy.lost("gone"))
        yield made
        stream.abort()
        await running


class TestDiscover:
    async def test_an_engine_that_speaks_extensions_is_asked_each_time(self, far: Far) -> None:
        for extensions, has_streams in ((("rois.stream", "x"), True), ((), False), (("rois.stream",), True)):
            await far.introduce(extensions=extensions)
            assert (far.proxy.extension is not None) == has_streams

    async def test_which_engines_speak_them(self, far: Far) -> None:
        await far.introduce()
        assert far.proxy.extension is not None
        assert far.proxy.extension.engines() == {"plain"}
        await far.introduce(engines=("other", "plain"))
        assert far.proxy.extension.engines() == {"plain"}
        await far.introduce(engines=("other",))
        assert far.proxy.extension.engines() == set()

    async def test_one_that_speaks_none_is_asked_once(self, far: Far) -> None:
        await far.introduce(plain=True)
        assert far.proxy.extension is None
        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("rois.system.get_profile"), **profile_result("toy"))
        assert (await discovering).profile.engine_ids() == ("plain",)

    async def test_one_that_does_not_answer_is_plain_until_it_does(
        self, far: Far, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("openrois.remote.remote_offer.HELLO_TIMEOUT", 0.01)
        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("rois.system.get_profile"), **profile_result("toy"))
        late = await far.asked("openrois.hello")
        await discovering
        assert (far.proxy.extension, far.proxy.speaks_extensions, far.changes) == (None, False, 0)
        # It is not asked again until it has answered.
        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("rois.system.get_profile"), **profile_result("toy"))
        await discovering
        assert far.proxy.extension is None
        hello = {"version": "1", "extensions": ["rois.stream"], "engines": [], "client_id": ""}
        await far.answer(late, **hello)
        asking = asyncio.ensure_future(far.proxy.query(TOY, "mood"))
        await far.answer(await far.asked("rois.query.query"), results=[])
        await asking
        assert far.changes == 1
        # One that is slow each time keeps what it has said, and asks for no new look each time.
        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("rois.system.get_profile"), **profile_result("toy"))
        late = await far.asked("openrois.hello")
        await discovering
        assert far.proxy.extension is not None
        assert far.proxy.speaks_extensions
        await far.answer(late, **hello, epoch=9)
        asking = asyncio.ensure_future(far.proxy.query(TOY, "mood"))
        await far.answer(await far.asked("rois.query.query"), results=[])
        await asking
        assert (far.changes, far.proxy.identity.epoch) == (1, 9)

    async def test_who_an_adapter_is(self, far: Far) -> None:
        assert far.proxy.identity == Identity()
        await far.introduce(plain=True)
        assert far.proxy.identity == Identity()

    async def test_the_instance_and_greatest_epoch_that_an_adapter_says(self, far: Far) -> None:
        await far.introduce(instance="this process", epoch=7)
        assert far.proxy.identity == Identity("this process", 7)

    async def test_one_that_fails_to_say(self, far: Far) -> None:
        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("rois.system.get_profile"), **profile_result("toy"))
        request = await far.asked("openrois.hello")
        error = {"code": -32603, "message": "Internal error"}
        await far.stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "error": error}))
        with pytest.raises(ComponentFailed):
            await discovering

    async def test_engines_that_change_all_the_time_come_as_they_are_read(self, far: Far) -> None:
        def entry(engine_id: str, parent_id: str) -> dict[str, Any]:
            return {"engine_id": engine_id, "parent_id": parent_id, "version": "1"}

        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("rois.system.get_profile"), **profile_result("toy"))
        await far.answer(await far.asked("openrois.hello"), version="1", extensions=["openrois.directory"])
        await far.answer(await far.asked("openrois.directory.list"), engines=[entry("main", "")])
        assert (await discovering).profile.engine_ids() == ("main",)
        await far.tell("openrois.directory.changed", changed=["calm", "busy0"])
        discovering = asyncio.ensure_future(far.proxy.discover())
        await far.answer(await far.asked("openrois.hello"), version="1", extensions=["openrois.directory"])
        for number in range(READS):
            asked = await far.asked("openrois.directory.read")
            await far.tell("openrois.directory.changed", changed=[f"busy{1 - number % 2}"])
            await far.answer(asked, engines=[entry(each, "main") for each in asked["params"]["engine_ids"]])
        assert set((await discovering).profile.engine_ids()) == {"main", "calm", "busy0", "busy1"}
        # The notification before, and what is left to be read.
        assert far.changes == 2

    async def test_a_change_is_passed_on(self, far: Far) -> None:
        await far.tell("rois.system.profile_changed")
        await far.introduce()
        assert far.changes == 1


class TestReasons:
    async def refuse(self, far: Far, *reasons: dict[str, Any]) -> str:
        asking = asyncio.ensure_future(far.proxy.query(TOY, "mood"))
        request = await far.asked("rois.query.query")
        for reason in reasons:
            named = {name: request["id"] if value == "ID" else value for name, value in reason.items()}
            await far.tell("openrois.reason", **named)
        await far.answer(request, return_code="TIMEOUT")
        with pytest.raises(TimedOut) as raised:
            await asking
        return str(raised.value)

    async def test_what_is_raised_says_it(self, far: Far) -> None:
        await far.introduce()
        assert await self.refuse(far, {"request_id": "ID", "reason": "it\n sleeps"}) == "it sleeps"

    async def test_what_a_newer_engine_says_besides_is_passed_over(self, far: Far) -> None:
        await far.introduce()
        assert await self.refuse(far, {"request_id": "ID", "reason": "it sleeps", "more": {"so": 1}}) == "it sleeps"

    async def test_the_last_word_counts(self, far: Far) -> None:
        await far.introduce()
        said = [{"request_id": "ID", "reason": str(number)} for number in range(100)]
        assert await self.refuse(far, *said) == "99"

    async def test_one_that_fits_nothing_is_forgotten(self, far: Far) -> None:
        await far.introduce()
        for reason in (
            {"reason": "x"},
            {"request_id": None, "reason": "x"},
            {"request_id": "ID ", "reason": "x"},
            {"request_id": -1, "reason": "x"},
            {"request_id": 1.5, "reason": "x"},
            {"request_id": True, "reason": "x"},
            {"request_id": ["ID"], "reason": "x"},
            {"request_id": "ID", "reason": "x" * 501},
            {"request_id": "ID", "reason": ""},
            {"request_id": "ID"},
            {"command_id": "ID", "reason": "x"},
            {"command_id": "unknown", "reason": "x"},
        ):
            assert await self.refuse(far, reason) == "the engine answered rois.query.query with TIMEOUT"
        # One that was said of a request comes too early for the next.
        assert await self.refuse(far, {"request_id": "ID", "reason": "it sleeps"}) == "it sleeps"
        assert await self.refuse(far) == "the engine answered rois.query.query with TIMEOUT"

    async def test_many_that_fit_nothing_take_no_memory(self, far: Far) -> None:
        await far.introduce()
        take = far.proxy.notifications()["openrois.reason"]
        take({"request_id": 1, "command_id": "c", "reason": "x" * 500})
        gc.collect()
        before = len(gc.get_objects())
        for number in range(20_000):
            take({"request_id": number, "command_id": f"c{number}", "reason": "x" * 500})
        gc.collect()
        assert len(gc.get_objects()) - before < 100
        assert len(far.proxy._commands) == 0

    async def test_of_a_command(self, far: Far) -> None:
        await far.introduce()
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        request = await far.asked("rois.command.execute")
        command_id = request["params"]["command_unit_list"][0]["command_id"]
        await far.tell("openrois.reason", command_id=command_id, reason="set target_positions first")
        await far.tell("rois.command.completed", command_id=command_id, status="ERROR")
        await far.answer(request)
        with pytest.raises(ComponentFailed, match=r"^set target_positions first$"):
            await invoking

    async def test_of_an_extension_s_method(self, far: Far) -> None:
        await far.introduce()
        assert far.proxy.extension is not None
        client = Client("ann", lambda _name, _params: None)
        for told, words in (((), "the engine answered signaling.restart with UNSUPPORTED"), (("gone",), "gone")):
            calling = asyncio.ensure_future(far.proxy.extension.call("signaling.restart", {"peer_id": "p"}, client))
            request = await far.asked("signaling.restart")
            for reason in told:
                await far.tell("openrois.reason", request_id=request["id"], reason=reason)
            await far.answer(request, return_code="UNSUPPORTED")
            with pytest.raises(Unsupported, match=f"^{words}$"):
                await calling


class TestInvoke:
    async def test_completed_may_come_before_the_reply(self, far: Far) -> None:
        await far.introduce()
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        request = await far.asked("rois.command.execute")
        command_id = request["params"]["command_unit_list"][0]["command_id"]
        await far.tell("rois.command.completed", command_id=command_id, status="ABORT")
        await far.answer(request)
        with pytest.raises(Aborted):
            await invoking

    async def test_lost_while_it_runs(self, far: Far) -> None:
        await far.introduce()
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        await far.answer(await far.asked("rois.command.execute"))
        far.stream.abort()
        with pytest.raises(EngineUnreachable):
            await invoking
        with pytest.raises(EngineUnreachable):
            await far.proxy.invoke(TOY, "start")

    async def test_lost_before_the_reply_leaves_no_failure_behind(
        self, far: Far, caplog: pytest.LogCaptureFixture
    ) -> None:
        await far.introduce()
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        await far.asked("rois.command.execute")
        far.stream.abort()
        with pytest.raises(EngineUnreachable):
            await invoking
        del invoking
        gc.collect()
        assert not caplog.records

    @pytest.mark.parametrize("timeout", [1, 0, -1])
    async def test_one_that_takes_longer_than_its_profile_says(self, far: Far, timeout: int) -> None:
        await far.introduce(timeout=timeout)
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        request = await far.asked("rois.command.execute")
        far.session.call_timeout = 0
        await far.answer(request)
        with pytest.raises(NotResponding, match="did not end in time"):
            await invoking
        far.session.call_timeout = 5
        command_id = request["params"]["command_unit_list"][0]["command_id"]
        await far.tell("rois.command.completed", command_id=command_id, status="OK")
        await far.introduce()

    async def test_any_number_may_stand_there(self, far: Far) -> None:
        await far.introduce(timeout=10**400)
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        request = await far.asked("rois.command.execute")
        await far.answer(request)
        command_id = request["params"]["command_unit_list"][0]["command_id"]
        await far.tell("rois.command.completed", command_id=command_id, status="OK")
        await invoking

    async def test_a_command_that_is_cancelled_is_forgotten(self, far: Far) -> None:
        await far.introduce()
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "start"))
        request = await far.asked("rois.command.execute")
        await far.answer(request)
        invoking.cancel()
        with pytest.raises(asyncio.CancelledError):
            await invoking
        command_id = request["params"]["command_unit_list"][0]["command_id"]
        await far.tell("rois.command.completed", command_id=command_id, status="OK")
        await far.introduce()

    async def test_what_waits_for_room_does_not_begin_behind_a_stop(self, far: Far) -> None:
        await far.introduce()
        # The other side does not read, and half of what may wait for it does.
        for _ in range(CONTROL_LIMIT // 2 + 100):
            far.session.notify("filler", {})
        starting = [asyncio.ensure_future(far.proxy.invoke(ref, "start")) for ref in (TOY, "plain/other")]
        setting = asyncio.ensure_future(far.proxy.invoke(TOY, "set_parameter"))
        await asyncio.sleep(0)
        assert not far.session.outbox.is_roomy
        stopping = asyncio.ensure_future(far.proxy.invoke(TOY, "stop"))
        begun: list[tuple[str, str]] = []
        while len(begun) < 2:
            message = json.loads(await far.stream.receive())
            if message["method"] == "rois.command.execute":
                (unit,) = message["params"]["command_unit_list"]
                begun.append((unit["component_ref"], unit["command_type"]))
                await far.answer(message)
                await far.tell("rois.command.completed", command_id=unit["command_id"], status="OK")
        assert begun == [(TOY, "stop"), ("plain/other", "start")]
        await asyncio.gather(stopping, starting[1])
        with pytest.raises(Aborted, match="was stopped before the command could be sent"):
            await starting[0]
        with pytest.raises(Aborted, match="was stopped before the command could be sent"):
            await setting

    async def test_results_are_asked_for_where_there_are_some(self, far: Far) -> None:
        await far.introduce()
        for command, results in (("start", ()), ("unheard of", ()), ("say", ("fine",))):
            invoking = asyncio.ensure_future(far.proxy.invoke(TOY, command))
            request = await far.asked("rois.command.execute")
            command_id = request["params"]["command_unit_list"][0]["command_id"]
            await far.answer(request)
            await far.tell("rois.command.completed", command_id=command_id, status="OK")
            if results:
                text = {"name": "text", "data_type_ref": "string", "value": "fine"}
                request = await far.asked("rois.command.get_command_result")
                assert request["params"] == {"command_id": command_id, "condition": ""}
                await far.answer(request, results=[text])
            assert tuple(result.value for result in await invoking) == results

    async def test_an_engine_without_a_profile_cannot_mint(self, far: Far) -> None:
        invoking = asyncio.ensure_future(far.proxy.invoke(TOY, "set_parameter"))
        await far.answer(await far.asked("rois.command.set_parameter"), command_id="plain/1")
        with pytest.raises(ComponentFailed):
            await invoking


class TestSubscribe:
    async def test_an_event_right_behind_the_reply_is_heard(self, far: Far) -> None:
        await far.introduce()
        heard: asyncio.Queue[Event | SubscriptionLost] = asyncio.Queue()
        subscribing = asyncio.ensure_future(far.proxy.subscribe(TOY, "laughed", heard.put_nowait))
        await far.answer(await far.asked("rois.event.subscribe"), subscribe_id="plain/s")
        event = {"event_id": "plain/e", "event_type": "laughed", "subscribe_id": "plain/s", "results": []}
        await far.tell("rois.event.notify_event", **event)
        await subscribing
        await far.introduce()
        told = heard.get_nowait()
        assert isinstance(told, Event)
        assert told.event_id == "plain/e"
        far.stream.abort()
        async with asyncio.timeout(60):
            assert await heard.get() == SubscriptionLost("gone")

    @pytest.mark.parametrize("how", ["timeout", "cancelled"])
    async def test_a_late_one_is_ended(self, far: Far, how: str) -> None:
        await far.introduce()
        far.session.call_timeout = 0 if how == "timeout" else 60
        subscribing = asyncio.ensure_future(far.proxy.subscribe(TOY, "laughed", lambda _item: None))
        request = await far.asked("rois.event.subscribe")
        subscribing.cancel()
        with pytest.raises((TimedOut, asyncio.CancelledError)):
            await subscribing
        await far.answer(request, subscribe_id="plain/late")
        assert (await far.asked("rois.event.unsubscribe"))["params"] == {"subscribe_id": "plain/late"}

    async def test_a_late_refusal_needs_nothing(self, far: Far) -> None:
        await far.introduce()
        far.session.call_timeout = 0
        with pytest.raises(TimedOut):
            await far.proxy.subscribe(TOY, "laughed", lambda _item: None)
        far.session.call_timeout = 60
        request = await far.asked("rois.event.subscribe")
        message = {"return_code": "UNSUPPORTED", "subscribe_id": ""}
        await far.stream.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": message}))
        await far.introduce()

    async def test_after_the_end_nothing_can_be_asked_or_ended(self, far: Far) -> None:
        await far.introduce()
        subscribing = asyncio.ensure_future(far.proxy.subscribe(TOY, "laughed", lambda _item: None))
        await far.answer(await far.asked("rois.event.subscribe"), subscribe_id="plain/s")
        subscribe_id = await subscribing
        far.proxy.lost("gone")
        await far.proxy.unsubscribe(subscribe_id)
        for asking in (far.proxy.query(TOY, "mood"), far.proxy.discover()):
            with pytest.raises(EngineUnreachable):
                await asking
        with pytest.raises(EngineUnreachable):
            await far.proxy.subscribe(TOY, "laughed", lambda _item: None)
