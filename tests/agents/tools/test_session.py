"""A caller's session: whatever is cancelled when, its body is given back."""

import asyncio
from dataclasses import replace

import pytest
from openrois_agents.tools import session as session_module
from openrois_agents.tools.held_body import HeldBody

from openrois.client import OutOfResources
from openrois.testing import memory_gateway
from tests.support.actors import Actor
from tests.support.mcp_hosts import PATIENCE, session_at

pytestmark = pytest.mark.extra(name="mcp")


async def test_a_body_is_given_back_also_when_that_is_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    giving, may_go_on, give_back = asyncio.Event(), asyncio.Event(), HeldBody.give_back

    async def slow(self: HeldBody) -> None:
        giving.set()
        await may_go_on.wait()
        await give_back(self)

    monkeypatch.setattr(HeldBody, "give_back", slow)
    async with memory_gateway(*Actor().parts) as gateway, gateway.client() as other:
        async with session_at(gateway.client) as session:
            await session.use_body(None, None, 0)
            cancelled = asyncio.ensure_future(session.give_back("the task is over"))
            await giving.wait()
            cancelled.cancel()
            await asyncio.wait({cancelled})
            may_go_on.set()
            await session.use_body(None, None, PATIENCE)
        (info,) = await other.bodies()
        assert info.free


async def test_a_session_that_ends_while_a_body_is_given_back_waits_for_that(monkeypatch: pytest.MonkeyPatch) -> None:
    giving, give_back = asyncio.Event(), HeldBody.give_back

    async def slow(self: HeldBody) -> None:
        giving.set()
        await asyncio.sleep(0.05)
        await give_back(self)

    monkeypatch.setattr(HeldBody, "give_back", slow)
    async with memory_gateway(*Actor().parts) as gateway, gateway.client() as other:
        async with session_at(gateway.client) as session:
            held = await session.use_body(None, None, 0)
            cancelled = asyncio.ensure_future(session.give_back("the task is over"))
            await giving.wait()
            cancelled.cancel()
        assert held.body.get("SpeechSynthesis") is None
        (info,) = await other.bodies()
        assert info.free


async def test_a_session_that_ends_waits_for_no_body() -> None:
    async with memory_gateway(*Actor().parts) as gateway, gateway.client() as other, other.bound("robot/reaction"):
        async with session_at(gateway.client) as session:
            waiting = asyncio.ensure_future(session.use_body(None, ["gesture"], 3_600))
            with pytest.raises(OutOfResources, match="is bound by another application"):
                async with session_at(gateway.client) as third:
                    await third.use_body(None, ["gesture"], 0)
        await asyncio.wait({waiting}, timeout=PATIENCE)
        assert waiting.cancelled()


async def test_of_only_so_many_bodies_the_consents_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_module, "MAX_ASKED", 1)
    async with memory_gateway(*Actor().parts) as gateway, session_at(gateway.client) as session:
        info = await session.body_info(None)
        first = await session.consents(info)
        assert await session.consents(info) is first
        await session.consents(replace(info, engine_id="another"))
        assert await session.consents(info) is not first
