"""What an agent may be told of visitors."""

from collections.abc import AsyncIterator
from typing import Any

import pytest
from openrois_agents.tools.consents import VisitorsNow, may_be_told, read_visitors

from openrois.client import BodyInfo, Client
from openrois.testing import memory_gateway
from tests.support.actors import Door, Hearing, Visitors, Words

pytestmark = pytest.mark.extra(name="mcp")


Body = tuple[Client, BodyInfo, Visitors]


@pytest.fixture
async def body() -> AsyncIterator[Body]:
    visitors = Visitors({"ann": "live recognition", "bob": "agent live recognition"})
    async with memory_gateway(Hearing(), Words(), Door(), visitors) as gateway, gateway.client() as client:
        (info,) = await client.bodies()
        yield client, info, visitors


async def told(body: Body, name: str, **data: Any) -> bool:
    client, info, _ = body
    return await may_be_told(client, info, f"{info.engine_id}/{name}", data)


async def test_who_consents_to_agents_and_who_does_not(body: Body) -> None:
    now = await read_visitors(body[0], body[1])
    assert now == VisitorsNow(
        {"ann": frozenset({"live", "recognition"}), "bob": frozenset({"agent", *("live", "recognition")})}
    )
    assert now.without_agents == ["ann"]


async def test_an_event_that_names_a_visitor_needs_that_visitors_consent(body: Body) -> None:
    assert not await told(body, "hearing", visitor_ref="ann")
    assert await told(body, "hearing", visitor_ref="bob")
    assert not await told(body, "hearing", visitor_ref="left")
    assert await told(body, "hearing", visitor_ref=None)


async def test_words_that_name_no_visitor_are_those_of_the_one_who_is_attended_to(body: Body) -> None:
    assert await told(body, "speech_recognizer")
    body[2].attended_ref = "ann"
    assert not await told(body, "speech_recognizer")
    assert await told(body, "door")
    body[2].attended_ref = "bob"
    assert await told(body, "speech_recognizer")


async def test_who_comes_and_goes_is_told_in_any_case(body: Body) -> None:
    assert await told(body, "visitors", visitor_ref="ann")


async def test_what_a_body_does_not_tell_is_not_assumed(body: Body) -> None:
    body[2].is_broken = True
    assert not await told(body, "hearing", visitor_ref="bob")
    assert not await told(body, "speech_recognizer")
    assert await told(body, "door")


async def test_a_body_that_tells_no_visitors_apart_has_none() -> None:
    async with memory_gateway(Words()) as gateway, gateway.client() as client:
        (info,) = await client.bodies()
        assert await may_be_told(client, info, f"{info.engine_id}/speech_recognizer", {})
