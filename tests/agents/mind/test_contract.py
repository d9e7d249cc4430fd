"""What every mind does: one suite for that of rules and that of a language model."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from datetime import date

import pytest
from openrois_agents.mind.contract import Mind, Turn
from openrois_agents.mind.limits import CONVERSATION, DAY, Budget
from openrois_agents.mind.model.chat import ModelSettings
from openrois_agents.mind.model.model_mind import ModelMind
from openrois_agents.mind.rules import RuleMind
from openrois_agents.tools.answer import Answer

from tests.support.chat_server import calls, chat_server, says
from tests.support.mind_stage import NotedStage

pytestmark = [pytest.mark.extra(name="speech"), pytest.mark.timeout(60)]

WAVE = Turn("please wave", "ann", 1)


@asynccontextmanager
async def minded(kind: str) -> AsyncIterator[Mind]:
    """A mind that waves, and says something to it, when it is told "please wave"."""
    if kind == "rules":
        async with RuleMind() as mind:
            yield mind
        return
    async with (
        chat_server() as server,
        ModelMind(ModelSettings(server.address, "m"), Budget(CONVERSATION, DAY, date.today)) as mind,
    ):
        for _ in range(4):
            server.script += (calls(("gesture", {"name": "wave"}), first="Look."), says("I have waved."))
        yield mind


kinds = pytest.mark.parametrize("kind", ["rules", "model"])


@kinds
async def test_a_mind_says_where_words_go(kind: str) -> None:
    async with minded(kind) as mind:
        assert mind.sends_to == ""
        assert mind.needs_visitor is (kind == "model")


@kinds
async def test_it_does_what_it_is_asked_through_the_stage(kind: str) -> None:
    async with minded(kind) as mind:
        stage = NotedStage()
        await mind.answer(WAVE, stage)
        assert stage.used == [("gesture", {"name": "wave"})]


@kinds
async def test_it_says_something_where_a_tool_fails(kind: str) -> None:
    async with minded(kind) as mind:
        stage = NotedStage({"gesture": Answer("Unsupported: it has no arms", {"failed": "Unsupported"})})
        await mind.answer(WAVE, stage)
        assert stage.said


@kinds
async def test_a_cancelled_answer_ends_at_once_and_the_next_one_is_whole(kind: str) -> None:
    cancelled = asyncio.Event()

    async def endless() -> Answer:
        try:
            await asyncio.Event().wait()
        finally:
            cancelled.set()
        raise AssertionError

    async with minded(kind) as mind:
        stage = NotedStage({"gesture": endless})
        answering = asyncio.ensure_future(mind.answer(WAVE, stage))
        await stage.until(lambda: bool(stage.used))
        answering.cancel()
        with suppress(asyncio.CancelledError):
            await answering
        assert answering.cancelled()
        assert cancelled.is_set()
        mind.interrupted("")
        again = NotedStage()
        mind.forget()
        if kind == "model":
            # The server was to be asked once more in the turn that was cancelled.
            await mind.answer(Turn("go on", "ann", 2), NotedStage())
        await mind.answer(WAVE, again)
        assert again.used == [("gesture", {"name": "wave"})]


@kinds
async def test_it_may_be_interrupted_and_forget_at_any_time(kind: str) -> None:
    async with minded(kind) as mind:
        mind.interrupted("never said")
        mind.forget()
        stage = NotedStage()
        await mind.answer(WAVE, stage)
        mind.interrupted("Look")
        mind.forget()
        mind.interrupted("")
        await mind.answer(WAVE, stage)
        assert len(stage.used) == 2
