"""What an agent may be told of visitors."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest
from openrois_agents.tools import consents as module
from openrois_agents.tools.consents import Consents, VisitorsNow, read_visitors
from openrois_agents.tools.event_log import EventLog, tellable

from openrois.client import BodyInfo, Client
from openrois.testing import memory_gateway
from tests.support.actors import Door, Hearing, Visitors, Words

pytestmark = pytest.mark.extra(name="mcp")

ANN, BOB = "live recognition", "agent live recognition"


class Body:
    """A body with two visitors, and what asks them."""

    def __init__(self, client: Client, info: BodyInfo, visitors: Visitors) -> None:
        self.client = client
        self.info = info
        self.visitors = visitors
        self.consents = Consents(client, info)

    async def told(self, name: str, event: str = "came", **data: Any) -> bool:
        concerns = self.consents.concern(f"{self.info.engine_id}/{name}", event, data)
        return not concerns or (await self.consents.ask())(data)


@pytest.fixture
async def body() -> AsyncIterator[Body]:
    visitors = Visitors({"ann": ANN, "bob": BOB})
    async with memory_gateway(Hearing(), Words(), Door(), visitors) as gateway, gateway.client() as client:
        (info,) = await client.bodies()
        yield Body(client, info, visitors)


async def test_who_consents_to_agents_and_who_does_not(body: Body) -> None:
    now = await read_visitors(body.client, body.info)
    assert now == VisitorsNow({"ann": frozenset(ANN.split()), "bob": frozenset(BOB.split())})
    assert now.without_agents == ["ann"]


async def test_an_event_that_names_a_visitor_needs_that_visitors_consent(body: Body) -> None:
    assert not await body.told("hearing", visitor_ref="ann")
    assert body.consents.withheld
    assert await body.told("hearing", visitor_ref="bob")
    assert not await body.told("hearing", visitor_ref="never there")
    assert not await body.told("door", visitor_ref="ann")


@pytest.mark.parametrize("name", ["speech_recognizer", "hearing"])
async def test_what_names_no_visitor_needs_the_consent_of_all_who_are_there(body: Body, name: str) -> None:
    assert not await body.told(name)
    body.visitors.consents["ann"] = BOB
    assert await body.told(name)
    body.visitors.consents.clear()
    assert await body.told(name, visitor_ref=None)


async def test_what_is_no_sense_is_told(body: Body) -> None:
    assert await body.told("door")


async def test_a_visitor_who_leaves_withdraws_nothing_and_one_who_stays_may(body: Body) -> None:
    assert await body.told("hearing", visitor_ref="bob")
    del body.visitors.consents["bob"]
    assert await body.told("hearing", visitor_ref="bob")
    body.visitors.consents["bob"] = ANN
    assert not await body.told("hearing", visitor_ref="bob")
    del body.visitors.consents["bob"]
    assert not await body.told("hearing", visitor_ref="bob")


async def test_a_visitor_who_withdraws_everything_and_leaves_at_once_has_withdrawn(body: Body) -> None:
    following = asyncio.ensure_future(body.consents.follow())
    try:
        assert await body.told("hearing", visitor_ref="bob")
        async with body.client.component("robot/visitors").event("visitor_changed") as changes:
            body.visitors.visitor_changed("bob", "microphone", "")
            del body.visitors.consents["bob"]
            body.visitors.visitor_changed("bob", "", "")
            await anext(changes), await anext(changes)
        assert not await body.told("hearing", visitor_ref="bob")
    finally:
        following.cancel()


async def test_only_so_many_visitors_are_remembered(body: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_REMEMBERED", 2)
    assert await body.told("hearing", visitor_ref="bob")
    for name in ("eve", "dora"):
        body.visitors.consents = {name: BOB}
        assert await body.told("hearing", visitor_ref=name)
    assert not await body.told("hearing", visitor_ref="bob")


async def test_who_comes_and_goes_is_told_and_who_was_sensed_is_not(body: Body) -> None:
    assert await body.told("visitors", "visitor_changed", visitor_ref="ann")
    assert await body.told("visitors", "attended", visitor_ref="ann")
    assert not await body.told("visitors", "sensed", visitor_ref="ann")


async def test_what_a_body_does_not_tell_is_not_assumed(body: Body) -> None:
    assert await body.told("hearing", visitor_ref="bob")
    body.visitors.is_broken = True
    assert not await body.told("hearing", visitor_ref="bob")
    assert not await body.told("speech_recognizer")
    assert await body.told("door")


async def test_a_body_that_tells_no_visitors_apart_has_none() -> None:
    async with memory_gateway(Words()) as gateway, gateway.client() as client:
        (info,) = await client.bodies()
        consents = Consents(client, info)
        assert consents.concern(f"{info.engine_id}/speech_recognizer", "speech_recognized", {})
        assert (await consents.ask())({})


async def test_the_log_is_read_with_the_consent_of_now(body: Body) -> None:
    log = EventLog()
    log.add("heard", "robot/hearing", {"visitor_ref": "bob"}, body.consents)
    log.add("opened", "robot/door", {})
    assert [each.name for each in await tellable(log.after(0))] == ["heard", "opened"]
    body.visitors.consents["bob"] = ANN
    assert [each.name for each in await tellable(log.after(0))] == ["opened"]
