"""A session over memory: what it serves, what it takes, how it ends, and what it does for a slow reader."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any

import pytest
from pydantic import BaseModel

from openrois.jsonrpc.handler import MAX_PROBLEMS
from openrois.jsonrpc.outbox import Outbox
from openrois.jsonrpc.request_queue import MAX_RUNNING_REQUESTS
from openrois.jsonrpc.session import (
    InvalidParams,
    Reply,
    RpcSession,
    SessionClosed,
    method,
)
from openrois.transport.memory import memory_pair
from tests.support.session import connected, echo, gate, settle


class Params(BaseModel):
    number: int
    inner: list[int] = []


class TestServing:
    async def test_an_answer_has_the_id_of_its_request(self) -> None:
        async with connected({"echo": echo}) as other:
            for request_id in ("a", 5, None, 2.5):
                await other.say(id=request_id, method="echo", params={"x": request_id})
                assert await other.hear() == {"id": request_id, "result": {"x": request_id}}

    async def test_answers_come_in_the_order_in_which_they_are_ready(self) -> None:
        opened, slow = gate()
        async with connected({"slow": slow, "echo": echo}) as other:
            await other.say(id=1, method="slow")
            await other.say(id=2, method="echo")
            assert (await other.hear())["id"] == 2
            opened.set()
            assert (await other.hear())["id"] == 1

    async def test_an_unknown_method_whatever_its_params(self) -> None:
        async with connected() as other:
            unusable: tuple[Any, ...] = ({}, [], 5)
            for params in unusable:
                await other.say(id=1, method="__class__", params=params)
                error = {"code": -32601, "message": "Method not found: __class__"}
                assert await other.hear() == {"id": 1, "error": error}

    async def test_params_that_are_no_object(self) -> None:
        async with connected({"echo": echo}) as other:
            await other.say(id=1, method="echo", params=[1])
            error = (await other.hear())["error"]
            assert error["code"] == -32602
            assert error["data"] == [{"path": "", "message": "params must be an object"}]

    async def test_params_that_do_not_fit_are_named_by_dotted_paths(self) -> None:
        async def taking(params: Params) -> Params:
            return params

        async with connected({"take": method(Params, taking)}) as other:
            await other.say(id=1, method="take", params={"inner": [1, "x"]})
            error = (await other.hear())["error"]
            assert (error["code"], sorted(p["path"] for p in error["data"])) == (-32602, ["inner.1", "number"])
            assert all(set(problem) == {"path", "message"} for problem in error["data"])
            await other.say(id=2, method="take", params={"number": 3})
            assert (await other.hear())["result"] == {"number": 3, "inner": []}

    async def test_a_refusal_does_not_grow_with_the_params(self) -> None:
        async def taking(params: Params) -> Params:
            return params

        async with connected({"take": method(Params, taking)}) as other:
            await other.say(id=1, method="take", params={"number": 1, "inner": ["x"] * 5000})
            assert len((await other.hear())["error"]["data"]) == MAX_PROBLEMS

    async def test_a_bug_is_answered_without_a_word_about_it(self, caplog: pytest.LogCaptureFixture) -> None:
        async def broken(_params: dict[str, Any]) -> None:
            raise ZeroDivisionError("the secret")

        async with connected({"broken": broken, "echo": echo}) as other:
            await other.say(id=1, method="broken")
            assert await other.hear() == {"id": 1, "error": {"code": -32603, "message": "Internal error"}}
            await other.say(id=2, method="echo")
            assert (await other.hear())["id"] == 2
        assert "the secret" in caplog.text

    async def test_a_result_that_cannot_be_written_is_a_bug_and_what_follows_the_reply_follows(self) -> None:
        followed: list[str] = []

        async def unwritable(_params: dict[str, Any]) -> Reply:
            return Reply({"x": float("nan")}, lambda: followed.append("x"))

        async with connected({"unwritable": unwritable}) as other:
            await other.say(id=1, method="unwritable")
            assert (await other.hear())["error"]["code"] == -32603
        assert followed == ["x"]

    async def test_the_reply_leaves_before_what_its_call_causes(self) -> None:
        async with connected() as other:

            async def start(_params: dict[str, Any]) -> Reply:
                return Reply({}, lambda: other.session.notify("caused", {}))

            other.session.methods = {"start": start}
            await other.say(id=1, method="start")
            assert "result" in await other.hear()
            assert (await other.hear())["method"] == "caused"

    async def test_what_explains_a_reply_stands_right_before_it(self) -> None:
        async def refuse(params: dict[str, Any]) -> Reply:
            return Reply({"ok": False}, lambda: other.session.notify("after", {}), params["why"])

        async with connected({"refuse": refuse}) as other:
            other.session.explain = lambda request_id, reason: other.session.notify("why", {reason: request_id})
            for request_id in ("a", 5, None, 2.5):
                await other.say(id=request_id, method="refuse", params={"why": "no"})
            for request_id in ("a", 5, None, 2.5):
                assert await other.hear() == {"method": "why", "params": {"no": request_id}}
                assert await other.hear() == {"id": request_id, "result": {"ok": False}}
                assert (await other.hear())["method"] == "after"
            await other.say(id=1, method="refuse", params={"why": ""})
            assert (await other.hear())["id"] == 1

    async def test_what_fails_after_the_reply_is_not_a_second_answer(self, caplog: pytest.LogCaptureFixture) -> None:
        def fail() -> None:
            raise ZeroDivisionError

        async def start(_params: dict[str, Any]) -> Reply:
            return Reply({}, fail)

        async with connected({"start": start, "echo": echo}) as other:
            await other.say(id=1, method="start")
            await other.say(id=2, method="echo")
            assert [await other.hear(), await other.hear()] == [{"id": 1, "result": {}}, {"id": 2, "result": {}}]
        assert "start" in caplog.text

    async def test_while_many_requests_run_no_more_is_read(self) -> None:
        opened, slow = gate()
        async with connected({"slow": slow, "echo": echo}, capacity=MAX_RUNNING_REQUESTS + 8) as other:
            for request_id in range(MAX_RUNNING_REQUESTS):
                await other.say(id=request_id, method="slow")
            await other.say(id="one more", method="echo")
            await settle()
            assert len(other.session.outbox) == 0
            opened.set()
            answers = [(await other.hear())["id"] for _ in range(MAX_RUNNING_REQUESTS + 1)]
            assert sorted(answers, key=str) == sorted([*range(MAX_RUNNING_REQUESTS), "one more"], key=str)

    async def test_violations_are_answered_once_and_logged_seldom(self, caplog: pytest.LogCaptureFixture) -> None:
        with caplog.at_level(logging.INFO):
            async with connected({"echo": echo}) as other:
                for _ in range(100):
                    await other.stream.send("nonsense")
                    assert (await other.hear())["error"]["code"] == -32700
                await other.say(id=7, result="unrequested")
                await other.say(id=8, method="echo")
                assert (await other.hear())["id"] == 8
        assert len(caplog.records) == 7


class TestNotifications:
    async def test_they_are_taken_in_order_and_unknown_ones_are_dropped(self) -> None:
        taken: list[Any] = []
        async with connected({"echo": echo}, {"known": lambda params: taken.append(params["n"])}) as other:
            for number, name in enumerate(("known", "unknown", "known", "echo")):
                await other.say(method=name, params={"n": number})
            await other.say(id=1, method="echo")
            assert (await other.hear())["id"] == 1
        assert taken == [0, 2]

    async def test_one_that_cannot_be_taken_ends_nothing(self, caplog: pytest.LogCaptureFixture) -> None:
        def misfit(params: dict[str, Any]) -> None:
            Params.model_validate(params)

        def broken(_params: dict[str, Any]) -> None:
            raise ZeroDivisionError

        with caplog.at_level(logging.INFO):
            async with connected({"echo": echo}, {"misfit": misfit, "broken": broken}) as other:
                await other.say(method="misfit", params={"number": "secret"})
                await other.say(method="broken")
                await other.say(id=1, method="echo")
                assert (await other.hear())["id"] == 1
        assert "secret" not in caplog.text
        assert "broken" in caplog.text


class TestEnding:
    async def test_every_waiter_fails_once_and_later_calls_at_once(self) -> None:
        async with connected() as other:
            calls = [asyncio.ensure_future(other.session.call("m", {})) for _ in range(3)]
            await other.hear()
            cancelled = calls.pop()
            cancelled.cancel()
            await other.stream.close(1001, "bye")
            for call in calls:
                with pytest.raises(SessionClosed, match="1001 bye"):
                    await call
            closed = await other.ended()
            assert (closed.code, closed.reason) == (1001, "bye")
            with pytest.raises(SessionClosed):
                await other.session.call("m", {})
            other.session.notify("told", {})
            other.session.post("m", {})
            assert len(other.session.outbox) == 0

    async def test_a_call_and_its_connection_may_end_together(self) -> None:
        async with connected() as other:
            call = asyncio.ensure_future(other.session.call("m", {}))
            await other.hear()
            other.stream.abort()
            call.cancel()
            assert (await other.ended()).code == 1006
            with pytest.raises((asyncio.CancelledError, SessionClosed)):
                await call

    async def test_handlers_that_run_are_cancelled_before_run_returns(self) -> None:
        ended: list[str] = []

        async def slow(_params: dict[str, Any]) -> None:
            try:
                await asyncio.Event().wait()
            finally:
                ended.append("slow")

        async with connected({"slow": slow}) as other:
            await other.say(id=1, method="slow")
            await settle()
            other.stream.abort()
            assert (await other.ended()).code == 1006
            assert ended == ["slow"]

    async def test_requests_that_wait_are_dropped(self) -> None:
        _opened, slow = gate()
        async with connected({"slow": slow}, capacity=MAX_RUNNING_REQUESTS + 8) as other:
            for request_id in range(MAX_RUNNING_REQUESTS + 4):
                await other.say(id=request_id, method="slow")
            await settle()
            assert len(other.session.request_queue) == 4
            other.stream.abort()
            assert (await other.ended()).code == 1006

    async def test_end_takes_nothing_more_and_leaves_the_stream(self) -> None:
        opened, slow = gate()
        async with connected({"slow": slow, "echo": echo}) as other:
            await other.say(id=1, method="slow")
            await settle()
            other.session.end_session(4000, "over")
            other.session.end_session(4001, "again")
            await other.say(id=2, method="echo")
            closed = await other.ended()
            assert (closed.code, closed.reason) == (4000, "over")
            assert not opened.is_set()
            assert len(other.session.outbox) == 0
            await other.session.stream.send("farewell")
            assert await other.stream.receive() == "farewell"
            other.session.end_session(4001, "again")

    async def test_close_sends_what_waits_first(self) -> None:
        async with connected() as other:
            for number in range(3):
                other.session.notify("told", {"n": number})
            await other.session.close(1008, "no")
            assert [(await other.hear())["params"]["n"] for _ in range(3)] == [0, 1, 2]
            closed = await other.ended()
            assert (closed.code, closed.reason) == (1008, "no")

    async def test_close_does_not_wait_for_ever_for_a_reader(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("openrois.jsonrpc.session._FLUSH_TIMEOUT", 0.01)
        async with connected(capacity=1) as other:
            for _ in range(5):
                other.session.notify("told", {})
            async with asyncio.timeout(60):
                await other.session.close()
            assert (await other.ended()).code == 1000

    async def test_an_answer_that_is_ready_after_the_close_goes_nowhere(self, monkeypatch: pytest.MonkeyPatch) -> None:
        async def linger(_code: int, _reason: str) -> None:
            """Stand in for a closing handshake that takes a while."""

        opened, slow = gate()
        async with connected({"slow": slow}) as other:
            await other.say(id=1, method="slow")
            await settle()
            monkeypatch.setattr(other.session.stream, "close", linger)
            await other.session.close()
            opened.set()
            await settle()
            assert len(other.session.outbox) == 0

    async def test_run_that_is_cancelled_fails_the_waiters(self) -> None:
        near, _far = memory_pair()
        session = RpcSession(near)
        running = asyncio.ensure_future(session.run())
        call = asyncio.ensure_future(session.call("m", {}))
        await settle()
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running
        with pytest.raises(SessionClosed):
            await call


class TestSlowReader:
    async def test_loses_events_oldest_first_and_nothing_else(self) -> None:
        async with connected({"echo": echo}, outbox=Outbox(control_limit=50, event_limit=2), capacity=1) as other:
            await other.say(id=0, method="echo")
            await settle()
            # One message waits in the pipe and one in the hands of the writer; the outbox holds what follows.
            other.session.notify("event", {"n": 0}, droppable=True)
            await settle()
            for number in range(1, 6):
                other.session.notify("event", {"n": number}, droppable=True)
                other.session.notify("control", {"n": number})
            heard = [await other.hear() for _ in range(9)]
            assert heard.pop(0)["id"] == 0
            numbers = {name: [m["params"]["n"] for m in heard if m["method"] == name] for name in ("event", "control")}
            assert numbers == {"event": [0, 4, 5], "control": [1, 2, 3, 4, 5]}

    async def test_what_is_dispensable_is_left_out_where_half_of_the_room_is_taken(self) -> None:
        async with connected({"echo": echo}, outbox=Outbox(control_limit=10), capacity=1) as other:
            await other.say(id=0, method="echo")
            await settle()
            other.session.notify("control", {"n": 0})
            await settle()
            for number in range(1, 7):
                other.session.notify("courtesy", {"n": number}, dispensable=True)
                other.session.notify("control", {"n": number})
            heard = [await other.hear() for _ in range(11)]
            assert heard.pop(0)["id"] == 0
            numbers = {
                name: [m["params"]["n"] for m in heard if m["method"] == name] for name in ("control", "courtesy")
            }
            assert numbers == {"control": [0, 1, 2, 3, 4, 5, 6], "courtesy": [1, 2, 3]}
            assert [m["method"] for m in heard[1:5]] == ["courtesy", "control"] * 2

    async def test_too_many_control_messages_abort_the_connection_once(self, caplog: pytest.LogCaptureFixture) -> None:
        async with connected(outbox=Outbox(control_limit=3), capacity=1) as other:
            waiting = asyncio.ensure_future(other.session.call("m", {}))
            for number in range(20):
                other.session.notify("control", {"n": number})
            closed = await other.ended()
            assert (closed.code, closed.reason) == (1006, "outbox overflow")
            with pytest.raises(SessionClosed):
                await waiting
        assert [record.levelname for record in caplog.records] == ["WARNING"]


async def test_invalid_params_say_what_is_wrong() -> None:
    assert str(InvalidParams([{"path": "a.b", "message": "is missing"}])) == "a.b: is missing"


def test_a_handler_is_what_method_returns() -> None:
    async def taking(params: Params) -> int:
        return params.number

    handler: Callable[[dict[str, Any]], Any] = method(Params, taking)
    assert asyncio.run(handler({"number": 4})) == 4


async def test_a_call_cancelled_while_a_session_ends_is_cancelled() -> None:
    ending, may_end = asyncio.Event(), asyncio.Event()

    async def linger(_params: dict[str, Any]) -> dict[str, Any]:
        try:
            await asyncio.Event().wait()
        finally:
            ending.set()
            await may_end.wait()
        return {}

    near, far = memory_pair()
    running = asyncio.ensure_future(RpcSession(near, {"linger": linger}).run())
    await far.send('{"jsonrpc": "2.0", "id": 1, "method": "linger"}')
    await settle()
    await far.close(1001, "the gateway stops")
    async with asyncio.timeout(60):
        await ending.wait()
        running.cancel()
        await settle()
        may_end.set()
        await asyncio.wait({running})
    assert running.cancelled()
