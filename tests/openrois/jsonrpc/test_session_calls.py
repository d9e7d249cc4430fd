"""A session's own requests: answers, failures, and answers that come too late."""

import asyncio
import logging
from typing import Any

import pytest

from openrois.jsonrpc import session
from openrois.jsonrpc.calls import MAX_LATE
from openrois.jsonrpc.outbox import Outbox
from openrois.jsonrpc.session import RpcError, SessionClosed
from tests.support.session import connected, echo, settle


async def test_answers_find_their_callers_in_any_order() -> None:
    async with connected() as other:
        calls = [asyncio.ensure_future(other.session.call("m", {"n": n})) for n in range(3)]
        asked = [await other.hear() for _ in calls]
        for question in reversed(asked):
            await other.say(id=question["id"], result=question["params"]["n"] * 10)
        assert await asyncio.gather(*calls) == [0, 10, 20]


async def test_an_error_answer_is_raised() -> None:
    async with connected() as other:
        call = asyncio.ensure_future(other.session.call("m", {}))
        question = await other.hear()
        await other.say(id=question["id"], error={"code": -32601, "message": "no", "data": 5})
        with pytest.raises(RpcError) as raised:
            await call
        assert (raised.value.code, raised.value.data) == (-32601, 5)
        assert str(raised.value) == "m: no (-32601)"


@pytest.mark.parametrize(
    ("data", "shown"),
    [
        (
            [{"path": "name", "message": "is\nmissing"}, {"path": "x", "message": "is unknown"}],
            "name: is missing; x: is unknown",
        ),
        ([{}, 7], ":"),
        ([{"path": "x", "message": "m"}] * 9, "x: m; x: m; x: m"),
        ([{"path": "x" * 900, "message": ""}], "x" * 300),
    ],
)
async def test_an_error_answer_says_which_params_are_wrong(data: Any, shown: str) -> None:
    async with connected() as other:
        call = asyncio.ensure_future(other.session.call("m", {}))
        question = await other.hear()
        await other.say(id=question["id"], error={"code": -32602, "message": "Invalid params", "data": data})
        with pytest.raises(RpcError) as raised:
            await call
        assert str(raised.value) == f"m: Invalid params (-32602): {shown}"


async def test_on_result_sees_the_result_before_the_next_message_is_looked_at() -> None:
    seen: list[str] = []

    def take(result: str) -> str:
        seen.append(result)
        return f"{result} and taken"

    async with connected(notifications={"told": lambda _params: seen.append("told")}) as other:
        call = asyncio.ensure_future(other.session.call("m", {}, on_result=take))
        question = await other.hear()
        await other.say(id=question["id"], result="answered")
        await other.say(method="told")
        assert await call == "answered and taken"
        await settle()
    assert seen == ["answered", "told"]


async def test_what_on_result_raises_the_caller_gets() -> None:
    def refuse(_result: Any) -> None:
        raise ZeroDivisionError

    async with connected() as other:
        call = asyncio.ensure_future(other.session.call("m", {}, on_result=refuse))
        await other.say(id=(await other.hear())["id"], result=1)
        with pytest.raises(ZeroDivisionError):
            await call


async def test_no_answer_in_time_and_a_late_one_is_dropped() -> None:
    async with connected({"echo": echo}) as other:
        other.session.call_timeout = 0
        with pytest.raises(TimeoutError):
            await other.session.call("m", {})
        question = await other.hear()
        await other.say(id=question["id"], result=1)
        await other.say(id="next", method="echo")
        assert (await other.hear())["id"] == "next"


@pytest.mark.parametrize("how", ["timeout", "cancelled", "cancelled with the answer"])
async def test_a_late_result_is_given_to_on_late_once(how: str) -> None:
    late: list[Any] = []
    async with connected({"echo": echo}) as other:
        timeout = 0 if how == "timeout" else 60
        call = asyncio.ensure_future(other.session.call("m", {}, timeout=timeout, on_late=late.append))
        question = await other.hear()
        if how == "cancelled with the answer":
            await other.say(id=question["id"], result="late")
            call.cancel()
        else:
            call.cancel()
            await asyncio.wait({call})
            await other.say(id=question["id"], result="late")
        await other.say(id=question["id"], result="again")
        await other.say(id="next", method="echo")
        assert (await other.hear())["id"] == "next"
        assert late == ["late"]


async def test_an_exception_of_on_late_and_a_late_error_are_harmless() -> None:
    def refuse(_result: Any) -> None:
        raise ZeroDivisionError

    async with connected({"echo": echo}) as other:
        for answer in ({"result": 1}, {"error": {"code": 1, "message": "no"}}):
            with pytest.raises(TimeoutError):
                await other.session.call("m", {}, timeout=0, on_late=refuse)
            await other.say(id=(await other.hear())["id"], **answer)
        await other.say(id="next", method="echo")
        assert (await other.hear())["id"] == "next"


async def test_an_error_for_a_cancelled_call_is_harmless() -> None:
    async with connected({"echo": echo}) as other:
        call = asyncio.ensure_future(other.session.call("m", {}))
        await other.say(id=(await other.hear())["id"], error={"code": 1, "message": "no"})
        call.cancel()
        await other.say(id="next", method="echo")
        assert (await other.hear())["id"] == "next"


async def test_late_answers_are_remembered_within_a_bound() -> None:
    late: list[Any] = []
    async with connected({"echo": echo}, capacity=MAX_LATE + 8) as other:
        for _ in range(MAX_LATE + 1):
            with pytest.raises(TimeoutError):
                await other.session.call("m", {}, timeout=0, on_late=late.append)
        asked = [(await other.hear())["id"] for _ in range(MAX_LATE + 1)]
        for request_id in asked[:3]:
            await other.say(id=request_id, result=request_id)
        await other.say(id="next", method="echo")
        assert (await other.hear())["id"] == "next"
        assert late == asked[1:3]


async def test_post_asks_and_drops_the_answer(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        async with connected({"echo": echo}) as other:
            other.session.post("m", {"n": 1})
            question = await other.hear()
            assert (question["method"], question["params"]) == ("m", {"n": 1})
            await other.say(id=question["id"], result=1)
            await other.say(id="next", method="echo")
            assert (await other.hear())["id"] == "next"
    assert not caplog.records


async def test_many_questions_at_once_wait_for_room() -> None:
    async with connected(outbox=Outbox(control_limit=8), capacity=1) as other:
        calls = [asyncio.ensure_future(other.session.call("m", {"n": n})) for n in range(50)]
        await settle()
        for _ in calls:
            await other.say(id=(await other.hear())["id"], result={})
        assert await asyncio.gather(*calls) == [{}] * 50


async def test_a_question_that_waits_for_room_fails_with_the_connection() -> None:
    async with connected(outbox=Outbox(control_limit=8), capacity=1) as other:
        calls = [asyncio.ensure_future(other.session.call("m", {})) for _ in range(50)]
        await settle()
        other.stream.abort()
        async with asyncio.timeout(60):
            ended = await asyncio.gather(*calls, return_exceptions=True)
        assert {type(end) for end in ended} == {SessionClosed}


async def test_a_pause_of_the_process_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "STOOD_STILL", 0.02)
    loop = asyncio.get_running_loop()
    answer: asyncio.Future[object] = loop.create_future()
    session._expire(answer, loop.time() - 1)
    assert not answer.done()
    with pytest.raises(TimeoutError):
        await answer
