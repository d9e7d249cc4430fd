"""A mind that a language model is, with a real server on this machine."""

import asyncio
import json
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from openrois_agents.mind.contract import Allowed, Mind, Turn
from openrois_agents.mind.limits import DAY, Budget, Limits
from openrois_agents.mind.model import chat
from openrois_agents.mind.model.chat import MAX_ANSWER, ModelSettings
from openrois_agents.mind.model.model_mind import MAX_AT_ONCE, MAX_ROUNDS, SETTLING, ModelMind
from openrois_agents.mind.model.prompts import FAILED, LOST_THREAD, NO_ANSWER, WITHDRAWN
from openrois_agents.mind.model.reply import MAX_REPLY
from openrois_agents.tools.answer import Answer
from openrois_body.services import server as services
from openrois_body.services.address import ServiceAddress

from openrois.client import ConnectionLost
from tests.support.chat_server import (
    Behaviour,
    ChatServer,
    breaking,
    bytes_of,
    call_chunk,
    calls,
    chat_server,
    chunk,
    floods,
    halting,
    refuses,
    says,
    streams,
)
from tests.support.http_answers import event, silent
from tests.support.mind_stage import NotedStage

pytestmark = [pytest.mark.extra(name="speech"), pytest.mark.timeout(120)]

HELLO = Turn("hello", "", 1)
PLENTY = Limits(1_000, 1_000_000, 1_000.0)


def budget(tokens: int = 1_000_000) -> Budget:
    return Budget(Limits(1_000, tokens, 1_000.0), DAY, lambda: date(2026, 11, 28))


@asynccontextmanager
async def minded(
    *script: Behaviour, tokens: int = 1_000_000, **settings: Any
) -> AsyncIterator[tuple[ModelMind, ChatServer]]:
    async with chat_server() as server:
        server.script.extend(script)
        async with ModelMind(ModelSettings(server.address, "m", **settings), budget(tokens)) as mind:
            yield mind, server


async def cancel(answering: "asyncio.Task[None]") -> None:
    answering.cancel()
    with suppress(asyncio.CancelledError):
        await answering


def roles(asked: dict[str, Any]) -> list[str]:
    return [each["role"] for each in asked["messages"]]


async def test_it_is_a_mind_that_speaks_sentence_by_sentence() -> None:
    async with minded(says("Hel", "lo! ", "I am a ro", "bot.")) as (mind, server):
        same: Mind = mind
        stage = NotedStage()
        await same.answer(Turn("hello", "ann", 1), stage)
        assert stage.said == ["Hello!", "I am a robot."]
        assert same.sends_to == ""
        (asked,) = server.asked
        assert (asked["model"], asked["stream"], asked["stream_options"]) == ("m", True, {"include_usage": True})
        assert asked["tool_choice"] == "auto"
        heard = asked["messages"][-1]["content"]
        assert heard.startswith("UNTRUSTED")
        assert heard.endswith('{"heard": "hello", "visitor": "ann"}')


async def test_a_sentence_is_spoken_while_the_model_goes_on() -> None:
    async with minded(halting(chunk({"content": "Hello! I"}), rest=[chunk({"content": " am here."})])) as (
        mind,
        server,
    ):
        stage = NotedStage()
        answering = asyncio.ensure_future(mind.answer(HELLO, stage))
        await stage.until(lambda: stage.said == ["Hello!"])
        assert not answering.done()
        server.go_on.set()
        await answering
        assert stage.said == ["Hello!", "I am here."]


async def test_a_sentence_is_spoken_where_no_further_token_comes_for_a_moment() -> None:
    assert SETTLING <= 0.3
    async with minded(halting(chunk({"content": "Hello there."}), rest=[chunk({"content": " Bye."})])) as (
        mind,
        server,
    ):
        stage = NotedStage()
        answering = asyncio.ensure_future(mind.answer(HELLO, stage))
        await stage.until(lambda: stage.said == ["Hello there."])
        server.go_on.set()
        await answering
        assert stage.said == ["Hello there.", "Bye."]


async def test_an_answer_ends_when_it_was_heard() -> None:
    async with minded(says("Hello.")) as (mind, _):
        stage = NotedStage()
        stage.goes_on.clear()
        answering = asyncio.ensure_future(mind.answer(HELLO, stage))
        await stage.until(lambda: bool(stage.said))
        assert not answering.done()
        stage.goes_on.set()
        await answering


async def test_tools_run_side_by_side_and_their_results_are_told() -> None:
    both = asyncio.Barrier(2)

    async def together() -> Answer:
        await both.wait()
        return Answer("done")

    script = (calls(("gesture", {"name": "wave"}), ("look_at", {"direction": "left"}), first="Watch."), says("There."))
    async with minded(*script) as (mind, server):
        stage = NotedStage({"gesture": together, "look_at": together})
        await mind.answer(HELLO, stage)
        assert stage.said == ["Watch.", "There."]
        assert sorted(stage.used) == [("gesture", {"name": "wave"}), ("look_at", {"direction": "left"})]
        assert roles(server.asked[1]) == ["system", "user", "assistant", "tool", "tool"]
        assert server.asked[1]["messages"][2]["content"] == "Watch."
        assert mind.figures.tool_calls == 2


async def test_calls_that_are_mistakes_are_told_and_not_made() -> None:
    script = calls(("use_body", {}), ("gesture", "[]"), ("stop", {"body": "other"}), ("look", {}))
    async with minded(script, says("I cannot.")) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.used == []
        results = [each["content"] for each in server.asked[1]["messages"] if each["role"] == "tool"]
        assert [each[:20] for each in results] == [
            "there is no tool 'us",
            "the arguments of ges",
            "stop takes no argume",
            "there is no tool 'lo",
        ]
        assert mind.figures.refused_calls == 4


async def test_only_so_many_calls_are_made_at_once() -> None:
    async with minded(calls(*(("where", {}) for _ in range(MAX_AT_ONCE + 2))), says("So.")) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert len(stage.used) == MAX_AT_ONCE
        results = [each["content"] for each in server.asked[1]["messages"] if each["role"] == "tool"]
        assert results[MAX_AT_ONCE:] == ["not called: no more than 4 tools are called at once"] * 2


async def test_a_turn_has_only_so_many_requests_and_the_last_cannot_call() -> None:
    async with minded(*(calls(("where", {})) for _ in range(MAX_ROUNDS + 3))) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert [each["tool_choice"] for each in server.asked] == ["auto"] * (MAX_ROUNDS - 1) + ["none"]
        assert len(stage.used) == MAX_ROUNDS - 1


async def test_a_picture_is_shown_to_a_model_that_sees() -> None:
    async with minded(calls(("look", {})), says("A plant."), sees=True) as (mind, server):
        stage = NotedStage({"look": Answer("a picture", picture=b"\xff\xd8")})
        await mind.answer(HELLO, stage)
        warning, picture = server.asked[1]["messages"][-1]["content"]
        assert "UNTRUSTED" in warning["text"]
        assert picture["image_url"]["url"] == "data:image/jpeg;base64,/9g="
        assert "look" in [each["function"]["name"] for each in server.asked[0]["tools"]]


async def test_a_consent_that_is_withdrawn_while_a_tool_runs_ends_the_answer_and_nothing_more_is_sent() -> None:
    async def withdraw() -> Answer:
        stage.may_go = Allowed(words=False, pictures=False)
        return Answer("done")

    async with minded(calls(("where", {}), first="A moment."), says("Welcome back.")) as (mind, server):
        stage = NotedStage({"where": withdraw})
        await mind.answer(Turn("my secret", "ann", 1), stage)
        assert stage.said == ["A moment.", WITHDRAWN]
        assert len(server.asked) == 1
        stage.may_go = Allowed(words=True, pictures=True)
        await mind.answer(Turn("here I am again", "ann", 2), stage)
        assert stage.said[2:] == ["Welcome back."]
        assert "secret" not in json.dumps(server.asked[1])


async def test_a_picture_is_not_sent_where_a_visitor_has_come_meanwhile_who_does_not_consent() -> None:
    async def come() -> Answer:
        stage.may_go = Allowed(words=True, pictures=False)
        return Answer("done")

    async with minded(calls(("look", {}), ("where", {})), says("I cannot look."), sees=True) as (mind, server):
        stage = NotedStage({"look": Answer("a picture", picture=b"\xff\xd8"), "where": come})
        await mind.answer(HELLO, stage)
        assert stage.said == ["I cannot look."]
        assert "image_url" not in json.dumps(server.asked[1])
        assert "The picture is not shown" in json.dumps(server.asked[1])


async def test_a_cancelled_answer_closes_the_connection_and_is_told_as_it_was_heard(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Nothing else ends the request.
    monkeypatch.setattr(services, "STALL_TIMEOUT", 3_600.0)
    script = halting(chunk({"content": "One is one. Two is two. Three"})), says("Yes.")
    async with minded(*script) as (mind, server):
        stage = NotedStage()
        answering = asyncio.ensure_future(mind.answer(HELLO, stage))
        await stage.until(lambda: len(stage.said) == 2)
        async with asyncio.timeout(30):
            await cancel(answering)
            await server.broken.wait()
        mind.interrupted("One is")
        await mind.answer(Turn("go on", "", 2), stage)
        assert [each["content"] for each in server.asked[1]["messages"] if each["role"] == "assistant"] == [
            "One is ..."
        ]
        assert mind.figures.interruptions == 1
        assert mind.figures.written > 0


async def test_a_tool_that_runs_when_an_answer_is_cancelled_is_cancelled_and_paired() -> None:
    ended = asyncio.Event()

    async def endless() -> Answer:
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()
        raise AssertionError

    async with minded(calls(("go_to", {"place": "door"})), says("Fine.")) as (mind, server):
        stage = NotedStage({"go_to": endless})
        answering = asyncio.ensure_future(mind.answer(HELLO, stage))
        await stage.until(lambda: bool(stage.used))
        await cancel(answering)
        assert ended.is_set()
        mind.interrupted("")
        await mind.answer(Turn("stop", "", 2), stage)
        assert roles(server.asked[1]) == ["system", "user", "assistant", "tool", "user"]
        assert "interrupted" in server.asked[1]["messages"][3]["content"]


async def test_a_conversation_that_is_over_is_forgotten() -> None:
    async with minded(says("One."), says("Two.")) as (mind, server):
        await mind.answer(HELLO, NotedStage())
        mind.forget()
        await mind.answer(HELLO, NotedStage())
        assert roles(server.asked[1]) == ["system", "user"]


async def test_an_empty_answer_is_said_to_be_none() -> None:
    async with minded(says("  "), streams(chunk({}), finish="stop")) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        await mind.answer(HELLO, stage)
        assert stage.said == [NO_ANSWER, NO_ANSWER]


async def test_tokens_are_counted_as_the_server_says_or_by_estimate() -> None:
    async with minded(says("Hello.", usage=(70, 30)), says("Hello you.", usage=None), tokens=100_000) as (mind, server):
        await mind.answer(HELLO, NotedStage())
        assert (mind.figures.read, mind.figures.written) == (70, 30)
        await mind.answer(HELLO, NotedStage())
        sent = len(json.dumps([server.asked[1]["messages"], server.asked[1]["tools"]]))
        assert mind.figures.read - 70 == pytest.approx(sent / 4, rel=0.01)
        assert mind.figures.written - 30 == 3
        assert mind.figures.seconds > 0


async def test_a_server_that_tells_too_few_tokens_is_not_believed() -> None:
    async with minded(says("Hello you. " * 250, usage=(0, 0)), tokens=100_000) as (mind, server):
        await mind.answer(HELLO, NotedStage())
        sent = len(json.dumps([server.asked[0]["messages"], server.asked[0]["tools"]]))
        assert mind.figures.read == pytest.approx(sent / 4, rel=0.01)
        assert mind.figures.written == pytest.approx(11 * 250 / 4, abs=2)


async def test_a_turn_ends_where_its_tokens_are_used_up() -> None:
    async with minded(calls(("where", {}), usage=(900, 100)), tokens=1_000) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert len(server.asked) == 1
        assert "talked for a long time" in stage.said[0]


async def test_names_that_the_gateway_does_not_tell_are_left_out() -> None:
    async with minded(says("Hello.")) as (mind, server):
        stage = NotedStage()
        stage.names = ConnectionLost("gone")
        await mind.answer(HELLO, stage)
        assert [each["function"]["name"] for each in server.asked[0]["tools"]] == ["look_at", "where", "stop"]


async def test_a_server_that_refuses_to_tell_the_usage_is_asked_without_it_from_then_on() -> None:
    async with minded(refuses(422), says("Hello.", usage=None), says("You.", usage=None)) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        await mind.answer(HELLO, stage)
        assert stage.said == ["Hello.", "You."]
        assert ["stream_options" in each for each in server.asked] == [True, False, False]


async def test_a_server_that_has_answered_is_not_asked_twice_when_it_refuses(caplog: pytest.LogCaptureFixture) -> None:
    async with minded(says("Hello."), refuses(400, {"error": {"message": "too long"}})) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        await mind.answer(HELLO, stage)
        assert stage.said == ["Hello.", FAILED]
        assert len(server.asked) == 2
        assert "refuses this (400): too long" in caplog.text


async def test_a_request_that_is_refused_both_ways_is_told(caplog: pytest.LogCaptureFixture) -> None:
    refusal = refuses(400, {"error": {"message": "no such model"}})
    async with minded(refusal, refusal) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == [FAILED]
        assert "refuses this (400): no such model" in caplog.text


async def test_what_the_model_thinks_is_not_said() -> None:
    async with minded(says("<th", "ink>Hm. Well.", "</think>\n", "Hello.")) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == ["Hello."]


def message(content: str) -> bytes:
    return json.dumps({"choices": [{"message": {"content": content}}]}).encode()


async def test_a_server_that_does_not_stream_is_understood() -> None:
    async with minded(bytes_of(message("Hello. You."), "application/json")) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == ["Hello.", "You."]


MALFORMED: dict[str, tuple[Behaviour, str]] = {
    "no JSON": (bytes_of(b"data: {\n\n"), "what came is no JSON"),
    "no text": (bytes_of(b"data: \xff\n\n"), "an event is no text in UTF-8"),
    "no choices": (streams({"object": "x"}), "there are no choices"),
    "a page": (bytes_of(b"<html>", "text/html"), "it answers text/html, not text/event-stream"),
    "an error in its stream": (streams({"error": {"message": "out of memory"}}), "it reports an error: out of memory"),
    "a huge line": (bytes_of(b"data: " + b"x" * 400_000), "an event has more than 262144 bytes"),
    "a huge whole answer": (floods(lambda _: b" " * 4_096, "application/json"), "sent more than was asked for"),
    "lines without end": (floods(lambda _: b"x" * 65_536), "an event has more than"),
    "events that say nothing": (floods(lambda _: b": ping " + b"x" * 4_096 + b"\n\n"), "sent more than was asked for"),
    "thousands of calls": (floods(lambda n: event(call_chunk(n, "{}", "where", f"c{n}"))), "calls more than 16 tools"),
    "arguments without end": (
        floods(lambda n: event(call_chunk(0, "x" * 999, "" if n else "where"))),
        "8000 characters",
    ),
    "503": (refuses(503, {"error": {"message": "loading"}}), "loading"),
    "404": (refuses(404), "404"),
}


@pytest.mark.parametrize("name", MALFORMED)
async def test_a_server_that_fails_is_a_polite_sentence_and_a_line(name: str, caplog: pytest.LogCaptureFixture) -> None:
    behaviour, reason = MALFORMED[name]
    async with minded(behaviour, says("I am back.")) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == [FAILED]
        assert stage.used == []
        assert [each.levelno for each in caplog.records if each.name.startswith("openrois_agents")] == [logging.WARNING]
        assert reason in caplog.text
        await mind.answer(HELLO, stage)
        assert stage.said == [FAILED, "I am back."]
        assert (mind.figures.requests, mind.figures.failures) == (2, 1)


async def test_an_answer_is_only_so_long(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    assert MAX_ANSWER == 4_000_000
    monkeypatch.setattr(chat, "MAX_ANSWER", 10_000)
    async with minded(streams(*(chunk({"reasoning_content": "x" * 100}) for _ in range(100)))) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == [FAILED]
        assert "sent more than was asked for" in caplog.text


async def test_an_answer_is_waited_for_only_so_long(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(chat, "PATIENCE", 0.0)
    async with minded(says("Hello. ", "You.")) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == [FAILED]
        assert "took too long for its answer" in caplog.text


async def test_tokens_without_end_are_cut_and_the_connection_is_closed() -> None:
    async with minded(floods(lambda n: event(chunk({"content": f"word{n} "})))) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        async with asyncio.timeout(30):
            await server.broken.wait()
        assert MAX_REPLY / 2 < len(" ".join(stage.said)) <= MAX_REPLY
        assert max(map(len, stage.said)) <= 240


STALLS: dict[str, tuple[Behaviour, str]] = {
    "before its headers": (silent, FAILED),
    "before its first event": (halting(), FAILED),
    "between events": (halting(chunk({"content": "Hello. You"})), LOST_THREAD),
    "within an event": (halting(chunk({"content": "Hello. You"}), then=[b'data: {"choi']), LOST_THREAD),
}


@pytest.mark.parametrize("where", STALLS)
async def test_a_server_that_stalls_is_left_after_a_while(
    where: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(services, "BEGIN_TIMEOUT", 0.3)
    monkeypatch.setattr(services, "STALL_TIMEOUT", 0.3)
    behaviour, sentence = STALLS[where]
    async with minded(behaviour) as (mind, server):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said[-1] == sentence
        assert "nothing came for 0.3 s" in caplog.text
        async with asyncio.timeout(30):
            await server.broken.wait()


async def test_a_connection_that_breaks_is_a_lost_thread() -> None:
    async with minded(breaking) as (mind, _):
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == ["I think.", LOST_THREAD]


async def test_a_server_that_is_down_is_a_polite_sentence(caplog: pytest.LogCaptureFixture) -> None:
    async with chat_server() as server:
        address = server.address
    async with ModelMind(ModelSettings(address, "m"), budget()) as mind:
        stage = NotedStage()
        await mind.answer(HELLO, stage)
        assert stage.said == [FAILED]
        assert "nothing listens there; check --llm-url" in caplog.text


async def test_the_key_is_shown_to_the_server_and_to_no_log(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    key = tmp_path / "key"
    caplog.set_level(logging.DEBUG)
    async with chat_server(key="secret-0123456789") as server:
        settings = ModelSettings(server.address, "m", key)
        async with ModelMind(settings, budget()) as mind:
            stage = NotedStage()
            await mind.answer(HELLO, stage)
            assert "the key cannot be read from" in caplog.text
            key.write_text("secret-wrong\n")
            await mind.answer(HELLO, stage)
            assert f"check the key in {key}" in caplog.text
            key.write_text("secret-0123456789\n")
            server.script.append(streams({"error": {"message": "bad key secret-0123456789"}}))
            server.script.append(refuses(422, {"error": {"message": "with secret-0123456789"}}))
            await mind.answer(HELLO, stage)
            await mind.answer(HELLO, stage)
            await mind.answer(HELLO, stage)
            assert stage.said == [FAILED] * 4 + ["Hello there."]
            assert server.keys == ["Bearer secret-0123456789"] * len(server.asked)
    assert "bad key (the key)" in caplog.text
    assert "secret" not in caplog.text


async def test_words_go_to_another_machine_by_name() -> None:
    settings = ModelSettings(ServiceAddress("https://h.example/v1"), "m")
    async with ModelMind(settings, budget()) as mind:
        assert mind.sends_to == "https://h.example"
