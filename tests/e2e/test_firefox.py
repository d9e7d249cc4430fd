"""A person with Firefox: watches the avatar, hears it speak, drives it, and shares it with a program."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Final

import pytest
import pytest_asyncio

from openrois.client import BindingLent, BindingRestored, Client, Notice
from openrois.errors import OutOfResources
from tests.support.demo import Demo
from tests.support.firefox import PATIENCE, FirefoxTab, firefox_at

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "panda3d"

_PICTURES: Final = """(() => {
    const video = document.querySelector("video");
    globalThis.pictures = 0;
    const count = () => { pictures += 1; video.requestVideoFrameCallback(count); };
    video.requestVideoFrameCallback(count);
})()"""
_SPREAD: Final = """(() => {
    const context = new OffscreenCanvas(64, 36).getContext("2d");
    context.drawImage(document.querySelector("video"), 0, 0, 64, 36);
    const { data } = context.getImageData(0, 0, 64, 36);
    const lumas = Array.from({ length: 64 * 36 }, (_, at) => data[4 * at + 1]);
    return Math.max(...lumas) - Math.min(...lumas);
})()"""
"""How far apart the darkest and the brightest point of the picture are, 0 to 255; 0 where nothing is shown."""
_ENERGY: Final = """(async () => {
    const reports = await Promise.all(probe.connections.map((each) => each.getStats()));
    const sounds = reports.flatMap((each) => [...each.values()]).filter(({ totalAudioEnergy }) => totalAudioEnergy);
    return Math.max(0, ...sounds.map(({ totalAudioEnergy }) => totalAudioEnergy));
})()"""
"""What was heard: a machine without a sound device has no running AudioContext in Firefox."""
_FROM_THE_MIDDLE: Final = """openrois.client.query("robot_position", "component_ref = 'avatar/system_info'")
    .then((results) => JSON.parse(results.find(({ name }) => name === "position_data").value)[0].split(","))
    .then(([x, y]) => Math.hypot(x, y))"""
"""How far the avatar says it is from where it stands at first, in metres."""
_SAYING: Final = "document.querySelector('[data-testid=say-state]').dataset.state"
_CONTROL: Final = "document.querySelector('[data-testid=control-toggle]')"
_LEGS: Final = "document.querySelector('[data-part=legs] .part-holder').innerText"
_ENTER: Final = "\ue007"


@pytest_asyncio.fixture(loop_scope="session")
async def firefox(firefox_program: Path, avatar: Demo, tmp_path: Path) -> AsyncIterator[FirefoxTab]:
    """The avatar's page in Firefox, playing; its console has to stay silent."""
    async with firefox_at(firefox_program, tmp_path, avatar.page) as tab:
        await tab.until("globalThis.openrois?.video?.status === 'STREAMING_RUNNING'")
        yield tab
        assert tab.complaints == []


async def test_a_visitor_with_firefox_sees_hears_and_drives_the_avatar(firefox: FirefoxTab) -> None:
    await firefox.read(_PICTURES)
    await firefox.until("pictures >= 30")
    assert await firefox.read(_SPREAD) > 60

    await firefox.click("say-text")
    await firefox.until("openrois.audio?.status === 'STREAMING_RUNNING'")
    silence = await firefox.read(_ENERGY)
    await firefox.type(f"Hello, I am the avatar.{_ENTER}")
    await firefox.until(f"{_SAYING} === 'done'")
    assert await firefox.read(_ENERGY) > silence + 0.01

    await firefox.click("control-toggle")
    await firefox.until(f"{_CONTROL}.ariaPressed === 'true'")
    await firefox.key_down("w")
    await firefox.until(f"{_FROM_THE_MIDDLE}.then((metres) => metres > 0.3)")
    await firefox.key_up("w")
    await firefox.click("control-toggle")
    await firefox.until(f"{_CONTROL}.ariaPressed === 'false'")


@pytest.mark.long
async def test_a_visitor_with_firefox_shares_the_avatar_with_a_program(firefox: FirefoxTab, avatar: Demo) -> None:
    async with Client(avatar.url) as program:
        notices = program.notices(BindingLent, BindingRestored)
        legs = program.component("avatar/navigation")
        await legs.bind()
        await firefox.until(f"{_LEGS} === 'A program'")
        await firefox.click("parts", "[data-part=legs] button")
        await firefox.until(f"{_LEGS}.startsWith('yours, from a program')")
        assert isinstance(await _next(notices), BindingLent)
        await firefox.click("parts", "[data-part=legs] button")
        assert await _next(notices) == BindingRestored("avatar/navigation")
        await firefox.until(f"{_LEGS} === 'A program'")

        await firefox.click("handover-yes")
        await firefox.until(f"{_CONTROL}.ariaPressed === 'true'")
        assert isinstance(await _next(notices), BindingLent)
        await firefox.click("stop-all")
        await firefox.until(f"{_CONTROL}.ariaPressed === 'false'")
        await legs.bind()  # what was lent does not come back to a program that has to wait
        with pytest.raises(OutOfResources, match="was stopped by visitor"):
            await legs.command("start")
        await firefox.click("stopped-hand-back")
        await firefox.until("document.querySelector('[data-testid=stopped]').hidden")
        assert not (await program.control.status(legs.component_ref)).stopped_by


@pytest.mark.long
async def test_a_visitor_with_firefox_is_heard_as_far_as_it_consents(firefox: FirefoxTab, avatar: Demo) -> None:
    words = "document.querySelector('[data-testid=consent-words]').innerText"
    microphone = "document.querySelector('[data-testid=microphone-toggle]')"
    async with Client(avatar.url) as program:
        visitors = program.component("avatar/visitors")
        await firefox.click("consent-recording")
        await firefox.click("microphone-toggle")
        await firefox.until("openrois.microphone.status === 'STREAMING_RUNNING'")
        await firefox.until(f"{words} === 'You may be heard and seen live, recognised and recorded.'")
        told = await visitors.query("visitors")
        assert (told["devices"], told["consent"]) == (["microphone"], ["live recognition recording"])
        async with visitors.event("visitor_changed") as changes, asyncio.timeout(PATIENCE):
            await firefox.click("consent-withdraw")
            while (await visitors.query("visitors"))["visitor_ref"]:
                await anext(changes)
        await firefox.until(f"{microphone}.disabled && {words}.startsWith('Microphone and camera stay off')")
        await firefox.until("openrois.microphone.status === 'STREAMING_NOT_CONNECTED'")


async def _next(notices: AsyncIterator[Notice]) -> Notice:
    async with asyncio.timeout(PATIENCE):
        return await anext(notices)
