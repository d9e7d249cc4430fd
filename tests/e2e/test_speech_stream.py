"""A page that speaks through the avatar by sound, with the TypeScript SDK in a real browser, and hears itself."""

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any, Final

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Error

from tests.support.browser import Visit, visiting
from tests.support.operated import operated_avatar

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

RATE: Final = 16_000
_PROGRAM: Final = (Path(__file__).parent / "speech.js").read_text(encoding="utf-8")
_ONCE_HEARD: Final = "probe.until(() => program.heard(begun)?.reduce((first, last) => last - first) > 300, 30000)"
_LENGTH: Final = "program.heard(begun)?.reduce((first, last) => last - first) ?? 0"


@pytest_asyncio.fixture(loop_scope="session")
async def speaking(browser: Browser, tmp_path: Path) -> AsyncIterator[Visit]:
    """The avatar's page, which listens, and a program in it that has the voice."""
    async with operated_avatar(tmp_path) as (gateway, _), visiting(browser, gateway.url) as visit:
        await visit.until("openrois.audio?.status === 'STREAMING_RUNNING'")
        await visit.page.evaluate(_PROGRAM, RATE)
        await visit.listen()
        await visit.read("program.quiet()")
        yield visit


async def _steps(visit: Visit) -> list[tuple[str, Any]]:
    return [(each["name"], each["value"]) for each in await visit.read("program.steps")]


async def _begin(visit: Visit) -> None:
    """Forget the steps so far; what is heard counts from now on."""
    await visit.read("program.steps.splice(0) && program.frames.splice(0) && (globalThis.begun = performance.now())")


async def _heard(visit: Visit) -> float:
    """Return for how many seconds the tone was heard, once there is silence."""
    await visit.read("program.quiet()")
    return float(await visit.read(_LENGTH)) / 1000


async def test_a_page_speaks_by_sound_is_heard_and_is_cut(speaking: Visit) -> None:
    visit = speaking
    await _begin(visit)
    spoken = await visit.read("program.speech.push(program.tone(0.4)).then(() => program.speech.finish())")
    assert spoken == {"seconds": 0.4, "reason": ""}
    assert [name for name, _ in await _steps(visit)] == ["started", "finished"]
    assert await _heard(visit) == pytest.approx(0.4, abs=0.15)

    await _begin(visit)
    # Much at once: one second of it leaves before any is heard, and no more than the body allows ever does.
    pushed = "program.pushed = program.speech.push(program.tone(9)).then(() => 'sent', ({ message }) => message)"
    await visit.read(f"void ({pushed})")
    cleared = await visit.read(f"{_ONCE_HEARD}.then(() => program.speech.clear())")
    assert cleared["reason"].startswith("the speech was cleared")
    assert await visit.read("program.pushed") == cleared["reason"]
    assert await _heard(visit) == pytest.approx(cleared["seconds"], abs=0.2)
    assert await _steps(visit) == [("started", await visit.read("program.steps[0].value")), ("finished", cleared)]
    frames = await visit.read("program.frames")
    assert all(frame["sent"] <= frame["granted"] for frame in frames)
    begun = await visit.read("program.steps[0].at")
    assert max(frame["sent"] for frame in frames if frame["at"] < begun) > 0.8 * RATE


@pytest.mark.long
async def test_opus_of_the_browser_is_heard_and_running_dry_is_told(speaking: Visit) -> None:
    visit = speaking
    packets = await visit.read("program.opus(program.tone(0.5, 48000)).then((all) => (program.packets = all)?.length)")
    if packets is None:
        pytest.skip("this browser does not encode Opus")
    assert packets >= 25
    await _begin(visit)
    begin = "JSON.stringify({event: 'begin', utterance: 1000, format: 'opus', rate: 48000})"
    await visit.read(f"(program.counts = false, program.channel.send({begin}))")
    frame = "program.frame(1000, index, packet)"
    await visit.read(f"program.packets.forEach((packet, index) => program.channel.send({frame}))")
    dry = await visit.until("program.told.find(({event, utterance}) => event === 'starved' && utterance === 1000)")
    assert dry["position"] == 20 * packets
    await visit.read("program.channel.send(JSON.stringify({event: 'end', utterance: 1000}))")
    over = await visit.until("program.told.find(({event, utterance}) => event === 'finished' && utterance === 1000)")
    assert over == {"event": "finished", "utterance": 1000, "position": 20 * packets}
    assert await _heard(visit) == pytest.approx(0.5, abs=0.15)


@pytest.mark.long
async def test_a_speech_that_runs_dry_goes_on_and_its_end_is_true(speaking: Visit) -> None:
    visit = speaking
    await _begin(visit)
    await visit.read("program.speech.push(program.tone(0.3), 'Two tones')")
    await visit.until("program.steps.find(({name}) => name === 'starved')")
    await visit.read("program.quiet()")
    spoken = await visit.read("program.speech.push(program.tone(0.3)).then(() => program.speech.finish())")
    assert spoken == {"seconds": 0.6, "reason": ""}
    names = [name for name, _ in await _steps(visit)]
    # On a slow machine the end comes after all was heard once more.
    assert (names[0], {*names[1:-1]}, names[-1]) == ("started", {"starved"}, "finished")
    assert await _heard(visit) > 0.5


@pytest.mark.long
async def test_stop_on_the_page_cuts_what_a_program_says_by_sound_and_all_that_it_has_pushed(speaking: Visit) -> None:
    visit = speaking
    await _begin(visit)
    message = "then(() => 'sent', ({message}) => message)"
    await visit.read(f"void (program.pushed = [1, 2].map(() => program.speech.push(program.tone(9)).{message}))")
    await visit.read(f"{_ONCE_HEARD}.then(() => document.querySelector('[data-testid=stop-all]').click())")
    first, second = await visit.read("Promise.all(program.pushed)")
    assert "stopped" in first
    assert second == first
    spoken = await visit.read("program.speech.finish()")
    # A busy browser draws out what it hears.
    assert await _heard(visit) == pytest.approx(spoken["seconds"], abs=0.3)
    assert [name for name, _ in await _steps(visit)] == ["started", "finished"]


@pytest.mark.long
async def test_a_second_program_is_refused_and_a_release_lets_it_speak(speaking: Visit, browser: Browser) -> None:
    async with visiting(browser, speaking.page.url) as visit:
        await visit.until("openrois.audio?.status === 'STREAMING_RUNNING'")
        with pytest.raises(Error, match="OUT_OF_RESOURCES"):
            await visit.page.evaluate(_PROGRAM, RATE)
        await speaking.read("program.speech.stop()")
        await visit.page.evaluate(_PROGRAM, 48_000)
        spoken = await visit.read("program.speech.push(program.tone(0.3)).then(() => program.speech.finish())")
        assert spoken == {"seconds": 0.3, "reason": ""}
