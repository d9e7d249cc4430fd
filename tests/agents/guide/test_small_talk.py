"""The guide's small talk: by whom a server's answers are heard, and what is said where it gives none."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from aiohttp import web

from openrois.adapter import query
from openrois.testing import memory_gateway
from openrois.types.codes import Purpose
from tests.support.actors import Consented, Visitors
from tests.support.demo import free_port
from tests.support.guided import example, guide, house, visitor

pytestmark = pytest.mark.media

AGENT = Purpose.RECOGNITION, Purpose.AGENT
FINE = json.dumps({"choices": [{"message": {"content": "I am fine."}}]})


@asynccontextmanager
async def model_server(answer: str | None) -> AsyncIterator[tuple[str, list[str]]]:
    """Run a server that gives one answer to everything, or none; return its address, and what it was asked."""
    asked: list[str] = []

    async def complete(request: web.Request) -> web.Response:
        asked.append(await request.text())
        if answer is None:
            await asyncio.Event().wait()
        return web.Response(text=answer, content_type="application/json")

    app = web.Application()
    app.router.add_post("/v1/chat/completions", complete)
    runner = web.AppRunner(app, shutdown_timeout=0.01)
    await runner.setup()
    port = free_port()
    await web.TCPSite(runner, "127.0.0.1", port).start()
    try:
        yield f"http://127.0.0.1:{port}/v1", asked
    finally:
        await runner.cleanup()


async def test_a_model_that_is_down_is_told_and_the_guide_goes_on(tmp_path: Path) -> None:
    model = f"http://127.0.0.1:{free_port()}/v1"
    async with house(tmp_path) as opened, guide(opened, tmp_path, model), visitor(opened, *AGENT) as ann:
        await opened.hears()
        opened.say("how are you", ann)
        await opened.tells("I cannot think about that now. I can lead you to: ")
        opened.say("take me to the plant", ann)
        await opened.tells("Here we are: the plant.")


@pytest.mark.parametrize(
    "answer",
    ["[]", "{}", "nonsense", FINE.replace("I am fine.", ""), FINE.replace('"I am fine."', "[1]"), "x" * 70_000, None],
    ids=["a list", "nothing", "no JSON", "no words", "no text", "too much", "none in time"],
)
async def test_the_guide_goes_on_where_its_model_answers_nonsense(
    tmp_path: Path, answer: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with (
        model_server(answer) as (model, asked),
        house(tmp_path) as opened,
        guide(opened, tmp_path, model),
        visitor(opened, *AGENT) as ann,
    ):
        monkeypatch.setattr("small_talk.TIMEOUT", 0.5 if answer is None else 30.0)
        await opened.hears()
        opened.say("how are you", ann)
        await opened.tells("I cannot think about that now. I can lead you to: ")
        assert asked


async def test_the_model_answers_a_visitor_that_consents_and_no_other_one(tmp_path: Path) -> None:
    async with (
        model_server(FINE) as (model, asked),
        house(tmp_path) as opened,
        guide(opened, tmp_path, model),
        visitor(opened, *AGENT) as ann,
    ):
        await opened.hears()
        for other in ("avatar/visitor/x", None):
            opened.say("my secret", other)
            await opened.tells("I can lead you to: ")
        assert not asked
        opened.say("how are you", ann)
        await opened.tells("I am fine.")
        assert "how are you" in asked[0]


async def test_what_is_heard_stays_here_where_that_is_all_a_visitor_consents_to(tmp_path: Path) -> None:
    async with (
        model_server(FINE) as (model, asked),
        house(tmp_path) as opened,
        guide(opened, tmp_path, model),
        visitor(opened, Purpose.RECOGNITION) as ann,
    ):
        await opened.hears()
        opened.say("my secret", ann)
        await opened.tells("I can lead you to: ")
    assert not asked


async def test_a_body_that_lists_no_consent_for_each_visitor_has_none_that_consents() -> None:
    class Broken(Visitors):
        @query
        async def visitors(self) -> Consented:
            return Consented(visitor_ref=("v1", "v2"), consent=("agent",))

    async with model_server(FINE) as (model, asked), memory_gateway(Broken({})) as gateway, gateway.client() as client:
        assert await example("small_talk").SmallTalk(client, model).answer("my secret", "v1") == ""
        assert not asked
