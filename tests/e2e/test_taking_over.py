"""A person on the page and a program share a body: parts are taken over for a time, handed back, and shown to all."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path

import pytest
import pytest_asyncio
from openrois_avatar.link.messages import Drive
from playwright.async_api import Browser, Locator, expect

from openrois.client import BindingLent, BindingLost, BindingRestored, Client, Notice
from openrois.client.components import Reaction, SpeechSynthesis
from openrois.errors import Aborted
from openrois.transport.credentials import Credentials
from tests.support.browser import Visit, visiting
from tests.support.deployment import until
from tests.support.guarded import fresh, guarded
from tests.support.operated import NotingEngine, noting_avatar

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

LEGS = "avatar/navigation"
_VOICE = "avatar/speech_synthesizer"


@dataclass
class Shared:
    """A body of which a program has the legs.

    Attributes:
        url: of the gateway's page, without a token.
        engine: the game engine of the body.
        program: its token ranks lowest.
        notices: what the program is told of its bindings.
    """

    url: str
    engine: NotingEngine
    program: Client
    notices: AsyncIterator[Notice]

    def page(self, subject: str) -> str:
        return f"{self.url}#token={fresh(sub=subject, rank='person')}"

    async def told(self) -> Notice:
        async with asyncio.timeout(60):
            return await anext(self.notices)


@pytest_asyncio.fixture(loop_scope="session")
async def shared(tmp_path: Path) -> AsyncIterator[Shared]:
    async with AsyncExitStack() as stack:
        here = await stack.enter_async_context(guarded(tmp_path))
        shown = Credentials(fresh(sub="avatar", roles="adapter", scope=["avatar/*"]))
        engine = await stack.enter_async_context(noting_avatar(tmp_path, f"{here.address}adapter", shown))
        await until(here.gateway.engine, lambda ids: "avatar" in ids)
        token = fresh(sub="night watch", rank="script")
        program = await stack.enter_async_context(Client(here.address, token=token))
        notices = program.notices(BindingLent, BindingLost, BindingRestored)
        await program.bind(LEGS)
        yield Shared(here.gateway.url, engine, program, notices)


def _part(visit: Visit, name: str) -> Locator:
    """Return the line of a part in the card that says who has it."""
    return visit.page.locator(f"[data-part={name}]")


async def test_a_person_takes_over_drives_and_hands_back_and_the_program_goes_on(
    browser: Browser, shared: Shared
) -> None:
    engine = shared.engine
    async with visiting(browser, shared.page("ann")) as visit:
        await visit.until("openrois.video?.status === 'STREAMING_RUNNING'")
        strip, legs = visit.item("handover"), _part(visit, "legs")
        await expect(strip).to_contain_text("night watch has control")
        await expect(legs).to_contain_text("night watch")
        await expect(visit.item("control-toggle")).to_be_disabled()
        await strip.get_by_role("button", name="Take over").click()
        await expect(visit.item("control-toggle")).to_have_attribute("aria-pressed", "true")
        await expect(strip).to_contain_text("You have control in place of night watch")
        await expect(legs).to_contain_text("yours, from night watch")
        lent = await shared.told()
        assert isinstance(lent, BindingLent)
        assert (lent.component_ref, lent.holder) == (LEGS, "ann")

        count = len(engine.times(Drive))
        await visit.page.keyboard.down("ArrowUp")
        await engine.until(lambda: len(engine.times(Drive)) > count + 1)
        await visit.page.keyboard.up("ArrowUp")
        await strip.get_by_role("button", name="Hand back").click()
        await expect(visit.item("control-words")).to_have_text("You have handed control back to night watch.")
        await expect(visit.item("control-toggle")).to_have_attribute("aria-pressed", "false")
        assert await shared.told() == BindingRestored(LEGS)
        await shared.program.component(LEGS).command("stop")
        await expect(strip).to_contain_text("night watch has control")


async def test_a_second_page_sees_who_has_which_part_and_a_closed_page_gives_it_back(
    browser: Browser, shared: Shared
) -> None:
    async with visiting(browser, shared.page("bob")) as bob:
        legs, gesture = (_part(bob, name) for name in ("legs", "gesture"))
        async with visiting(browser, shared.page("ann")) as ann:
            await _part(ann, "legs").get_by_role("button", name="Take over").click()
            await expect(legs).to_contain_text("ann, from night watch")
            await expect(legs).to_contain_text("s left")
            await expect(gesture).to_contain_text("free")
            # ann does not rank lower than bob: she is asked, once that has turned out.
            await legs.get_by_role("button", name="Take over").click()
            await expect(legs.get_by_role("button")).to_be_hidden()
            await expect(bob.item("handover").get_by_role("button", name="Ask for it")).to_be_visible()
        assert isinstance(await shared.told(), BindingLent)
        assert await shared.told() == BindingRestored(LEGS)
        await expect(legs.locator(".part-holder")).to_have_text("night watch")


async def test_a_person_can_always_say_a_sentence(browser: Browser, shared: Shared) -> None:
    program = shared.program
    async with program.body(SpeechSynthesis, optional=(Reaction,)) as body:
        await body[SpeechSynthesis].set(speech_text="This is not heard to its end. " * 12)
        speaking = await body[SpeechSynthesis].command("start").execute()
        async with visiting(browser, shared.page("ann")) as visit:
            await visit.item("say-text").fill("Excuse me.")
            await visit.item("say-text").press("Enter")
            await expect(visit.item("say-state")).to_have_attribute("data-state", "done", timeout=60_000)
        with pytest.raises(Aborted, match="higher rank"):
            await speaking
        lent = await shared.told()
        assert isinstance(lent, BindingLent)
        assert (lent.component_ref, lent.holder) == (_VOICE, "ann")
        assert await shared.told() == BindingRestored(_VOICE)
