"""A conversation before a gateway of real connections: a person stops its body, or it dies."""

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path

from tests.support.actors import Actor
from tests.support.conversing import PATIENCE, Conversing, conversing, until
from tests.support.conversing_site import conversing_site


async def test_a_person_who_stops_the_body_ends_the_conversation_until_it_is_handed_back(tmp_path: Path) -> None:
    actor = Actor(at_once=False)
    async with (
        conversing_site(tmp_path) as site,
        site.body("robot", actor),
        site.client("ann", "person") as person,
        conversing(site.client, actor) as talking,
    ):
        talking.hear("good morning")
        await actor.speaking.begun.wait()
        await person.control.stop_all("robot")
        await talking.until_free()
        await site.until("robot", free=True)
        assert talking.mind.forgotten == 1
        talking.hear("are you there")
        actor.speaking.may_end.set()
        await person.control.release_stop("robot")
        async with asyncio.timeout(PATIENCE):
            while not talking.figures.answers:
                talking.hear("are you there now")
                await asyncio.sleep(0.2)  # a visitor repeats it
        assert {each.text for each in talking.mind.turns[1:]} == {"are you there now"}


async def test_a_conversation_goes_on_with_another_body_when_its_own_dies(tmp_path: Path) -> None:
    first, second = Actor(), Actor()
    async with conversing_site(tmp_path) as site, AsyncExitStack() as stack, AsyncExitStack() as dying:
        await stack.enter_async_context(site.body("first", first))
        await dying.enter_async_context(site.body("second", second))
        talking = await stack.enter_async_context(conversing(site.client, second))
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        assert _held(talking) == "second"
        await dying.aclose()
        await until(lambda: first.speaking.did == ["I go on here."])
        assert _held(talking) == "first"
        first.hearing.heard("thank you", True)
        await until(lambda: talking.figures.answers == 2)
        assert (talking.figures.conversations, talking.figures.moves) == (1, 1)
        assert talking.mind.turns[-1].number == 2


def _held(talking: Conversing) -> str:
    held = talking.session.held
    return "" if held is None else held.engine_id


async def test_a_conversation_is_over_when_its_body_dies_and_there_is_no_other(tmp_path: Path) -> None:
    actor = Actor()
    async with conversing_site(tmp_path) as site, AsyncExitStack() as stack, AsyncExitStack() as dying:
        await dying.enter_async_context(site.body("lone", actor))
        talking = await stack.enter_async_context(conversing(site.client, actor))
        talking.hear("good morning")
        await until(lambda: talking.figures.answers == 1)
        await dying.aclose()
        await talking.until_free()
        assert talking.session.held is None
        assert talking.mind.forgotten == 1
