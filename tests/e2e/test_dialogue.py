"""A person talks with a program through a body: the page says where words go, and shows what was said and heard."""

from collections.abc import AsyncIterator
from typing import Final

import numpy as np
import pytest
import pytest_asyncio
from playwright.async_api import expect

from openrois.client import Client
from openrois.client.component import ComponentProxy
from openrois.client.components import SpeechSynthesis
from tests.support.browser import PATIENCE, Visit
from tests.support.demo import Demo
from tests.support.devices import Devices
from tests.support.hearing import spoken, stereo_48k

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

ENGINE: Final = "puppet"
_LONG: Final = PATIENCE * 1000
_GRAMMAR: Final = "#JSGF V1.0; grammar walk; public <walk> = go to the window;"
_MODEL: Final = "https://model.example"


@pytest.fixture(scope="module", autouse=True)
def voice_of_the_person(devices_of_all: Devices) -> Devices:
    """The browser's microphone: a sentence and a pause, again and again."""
    devices_of_all.hear(stereo_48k(np.concatenate([spoken("go to the window"), np.zeros(32_000, np.int16)]))[:, 0])
    return devices_of_all


@pytest_asyncio.fixture(loop_scope="session")
async def mind(avatar: Demo) -> AsyncIterator[ComponentProxy]:
    """The dialogue of a program that has the voice and expects one sentence."""
    async with Client(avatar.url) as program:
        recognizer = program.component("avatar/speech_recognizer")
        await recognizer.set_parameter(grammar=_GRAMMAR)
        dialogue = program.component("avatar/dialogue")
        async with dialogue.bound():
            await dialogue.set_parameter(sent_to=_MODEL, can_be_said=["go to the window", "wave"])
            yield dialogue


async def test_a_person_agrees_talks_while_holding_the_button_and_reads_what_was_heard(
    guest: Visit, mind: ComponentProxy
) -> None:
    await expect(guest.item("dialogue-sent-to")).to_contain_text(f"would be sent to {_MODEL}", timeout=_LONG)
    await guest.press("dialogue-agree-button")
    await expect(guest.item("consent-agent")).to_be_checked()
    await expect(guest.item("consent-transfer")).to_be_checked()
    await expect(guest.item("dialogue-sent-to")).to_have_text(f"To be answered, what you say is sent to {_MODEL}.")
    await expect(guest.item("dialogue-agree")).to_be_hidden()

    assert await guest.read("openrois.microphone.captured") is None
    await guest.item("talk").focus()
    await guest.page.keyboard.down("Space")
    await expect(guest.item("talk")).to_have_text("Speak now", timeout=_LONG)
    heard = guest.item("dialogue-lines").locator("[data-kind=heard]").first
    await expect(heard).to_contain_text("go to the window", timeout=_LONG)
    await expect(heard.locator(".by")).to_have_text("You")
    await guest.page.keyboard.up("Space")
    assert await guest.read("openrois.microphone.captured.enabled") is False
    await guest.until("openrois.microphone.captured === null")

    speech = SpeechSynthesis(mind.client, "avatar/speech_synthesizer")
    async with speech.bound():
        await speech.set_parameter(speech_text="I go there.")
        await speech.start()
    said = guest.item("dialogue-lines").locator("[data-kind=said]").last
    await expect(said).to_contain_text("I go there.", timeout=_LONG)


async def test_the_button_is_let_go_of_with_the_pointer_and_with_the_focus(guest: Visit) -> None:
    talk = guest.item("talk")
    await talk.hover(timeout=_LONG)
    for let_go in (guest.page.mouse.up, lambda: talk.evaluate("button => button.blur()")):
        await talk.focus()
        await guest.page.mouse.down()
        await expect(talk).to_have_attribute("aria-pressed", "true")
        await let_go()
        await expect(talk).to_have_attribute("aria-pressed", "false")
        await guest.page.mouse.up()
    await guest.until("openrois.microphone.captured === null")


async def test_what_the_program_said_is_gone_with_it(guest: Visit, mind: ComponentProxy) -> None:
    await mind.set_parameter(wake_word="computer")
    await expect(guest.item("dialogue-wake")).to_contain_text("computer", timeout=_LONG)
    await expect(guest.item("talk")).to_be_hidden()
    await expect(guest.item("dialogue-can-be-said").locator("li")).to_have_text(["go to the window", "wave"])
    await mind.release()
    await expect(guest.item("dialogue-wake")).to_be_hidden(timeout=_LONG)
    await expect(guest.item("dialogue-sent-to")).to_be_hidden()
    await expect(guest.item("talk")).to_be_visible()
    await mind.bind()
