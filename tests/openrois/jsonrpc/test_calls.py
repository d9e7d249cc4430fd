"""Unanswered requests, without a connection."""

import asyncio
from typing import Any

import pytest

from openrois.jsonrpc.calls import Calls, SessionClosed
from openrois.jsonrpc.protocol import ErrorResponse, Peer, Response


@pytest.fixture
async def calls() -> Calls:
    return Calls(Peer())


async def test_an_answer_for_a_caller_that_is_leaving_goes_to_on_late(calls: Calls) -> None:
    late: list[Any] = []
    for on_late in (late.append, None):
        request_id, _, answer = calls.open("m", {}, None, on_late)
        answer.cancel()
        calls.settle(Response(request_id, "late"))
        calls.abandon(request_id)
    assert late == ["late"]


async def test_a_late_error_ends_the_wait_for_a_late_result(calls: Calls) -> None:
    late: list[Any] = []
    request_id, _, _ = calls.open("m", {}, None, late.append)
    calls.abandon(request_id)
    calls.refuse(ErrorResponse(request_id, 1, "no"))
    calls.settle(Response(request_id, "late"))
    assert not late


async def test_the_end_fails_calls_that_still_wait(calls: Calls) -> None:
    (_, _, waiting), (_, _, leaving), (late_id, _, _) = (calls.open("m", {}, None, pytest.fail) for _ in range(3))
    leaving.cancel()
    calls.abandon(late_id)
    calls.fail("the end")
    with pytest.raises(SessionClosed, match="the end"):
        await waiting
    with pytest.raises(asyncio.CancelledError):
        await leaving
    calls.settle(Response(late_id, 1))
