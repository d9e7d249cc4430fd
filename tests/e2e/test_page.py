"""The page: keyboard operation, small screens, light and dark, contrast, texts, and speech."""

import re
from pathlib import Path
from typing import Final

import pytest
from playwright.async_api import Browser, Page, expect

from openrois.client import Client
from openrois.client.components import SpeechSynthesis
from tests.support.browser import Visit, visiting
from tests.support.conversation import SAYING, all_stopped, aloud, meet, outcome, say, speak
from tests.support.demo import Demo
from tests.support.speech_timing import AUDIBLE, PRESS_STOP, said

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "puppet"

_CONTRAST: Final = Path(__file__).with_name("contrast.js")
_READABLE: Final = 4.5
_MARKED: Final = "document.querySelector('[data-testid=say-words] mark')?.textContent"
_BUFFER: Final = """probe.connections.flatMap((each) => each.getReceivers())
    .filter(({ track }) => track.kind === "audio").forEach((each) => (each.jitterBufferTarget = 700))"""
"""Makes the browser hold sound back for 0.7 s."""
_TOO_EARLY: Final = 300
"""Milliseconds by which `completed` may come before the last sound on a busy machine;
`python -m openrois_bench.spoken.speech` measures what it is. Without knowing the buffer it is 0.5 s too early."""
_START_AND_STOP: Final = """async (milliseconds) => {
    document.querySelector("[data-testid=say-text]").form.requestSubmit();
    if (milliseconds) await new Promise((resolve) => setTimeout(resolve, milliseconds));
    document.querySelector("[data-testid=say-stop]").click();
}"""
_FOCUS: Final = """(() => {
    const { dataset, className } = document.activeElement;
    const { outlineStyle, outlineWidth } = getComputedStyle(document.activeElement);
    const shown = outlineStyle !== "none" && parseFloat(outlineWidth) >= 2;
    return { name: dataset.testid ?? dataset.role ?? className, shown };
})()"""
_BEYOND: Final = """[...document.querySelectorAll("body *")].filter((each) =>
    each.checkVisibility() && each.getBoundingClientRect().right > innerWidth + 0.5
).map(({ outerHTML }) => outerHTML.slice(0, 100))"""

_INTERNAL: Final = re.compile(r"\b[A-Z]{2,}_[A-Z_]+\b|[0-9a-f]{24}|[0-9a-f]{6}…|\bavatar/|'s now\b|\bby local\b")
"""Codes, ids and references, which are for programs."""


async def _tab(page: Page, count: int) -> list[str]:
    """Press Tab `count` times; return where the focus went, and check that it is visible there."""
    stops = []
    for _ in range(count):
        await page.keyboard.press("Tab")
        focus = await page.evaluate(_FOCUS)
        assert focus["shown"], focus
        stops.append(focus["name"])
    return stops


async def test_tab_key_follows_the_reading_order(guest: Visit) -> None:
    buttons = guest.page.locator("button.reaction")
    reactions = await buttons.evaluate_all("all => all.map((each) => each.dataset.testid)")
    assert len(reactions) >= 10
    await guest.page.keyboard.press("Shift")  # any key lets the page sound, and changes that button
    await expect(guest.item("sound-off")).to_be_visible()
    await expect(guest.item("microphone-toggle")).to_be_visible()  # once the avatar has said what it takes
    await expect(guest.item("say-language")).to_be_visible()  # once the voice has said what it speaks
    await guest.until("document.querySelector('[data-testid=map]').dataset.figure")
    away = await guest.item("map-back").is_visible()
    order = [
        *("skip", "show-avatar", "show-inspector", "stop-all", "help-open", "theme-toggle", "stage"),
        *("sound-off", "captions-toggle", "statistics-toggle", "control-toggle", "fullscreen"),
        *("say-text", "say-language", "say-send"),  # pause and stop have nothing to do yet
        *reactions,
        *("dialogue-lines", "talk"),
        *(["map-open", "map-back"] if away else ["map-open"]),  # other tests may have sent it away
        *("map", "viewpoint", "consent-live", "consent-recognition", "consent-agent", "consent-recording"),
        *("consent-transfer", "microphone-toggle", "camera-toggle"),
        *("video-suspend", "video-disconnect", "audio-suspend", "audio-disconnect"),
        *("log-filter", "log-pause", "log-clear", "log-row"),
    ]
    assert await _tab(guest.page, len(order)) == order


async def test_texts_of_the_page_have_no_codes_ids_and_references(guest: Visit) -> None:
    texts = []
    await say(guest, "Parrots whistle loudly, and the others listen to them.")
    await guest.until(f"{SAYING} === 'speaking'")
    texts.append(await guest.page.inner_text("body"))
    await guest.press("stop-all")
    await all_stopped(guest)
    texts.append(await guest.page.inner_text("body"))
    await guest.press("audio-disconnect")
    await guest.status("audio", "NOT_CONNECTED")
    await expect(guest.item("log")).to_contain_text("audio streaming, not connected")
    texts.append(await guest.page.inner_text("body"))
    titles = await guest.page.locator("[title]").evaluate_all("all => all.map((each) => each.title)")
    assert [found for text in (*texts, *titles) for found in _INTERNAL.findall(text)] == []


@pytest.mark.long
async def test_keyboard_alone_operates_the_page(guest: Visit) -> None:
    keyboard = guest.page.keyboard
    await keyboard.press("Tab")
    await keyboard.press("Enter")  # the first stop skips to the text
    await expect(guest.item("say-text")).to_be_focused()
    await keyboard.type("Hello.")
    await keyboard.press("Enter")
    await expect(guest.item("say-state")).to_contain_text("Done after")
    assert await outcome(guest, "avatar/speech_synthesizer", "start") == "OK"
    await expect(guest.item("say-text")).to_have_value("")

    await keyboard.press("Escape")  # leaves the text, so that keys are shortcuts
    await keyboard.press("1")
    await expect(guest.item("reaction-state")).to_contain_text("done after")
    await keyboard.press("s")
    await guest.status("video", "SUSPENDED")
    await keyboard.press("s")
    await guest.status("video", "RUNNING")

    await guest.item("video-disconnect").focus()
    await keyboard.press("Enter")
    await guest.status("video", "NOT_CONNECTED")
    await expect(guest.item("video-connect")).to_be_focused()
    await keyboard.press("Enter")
    await guest.status("video", "RUNNING")

    await keyboard.press("?")
    await expect(guest.page.get_by_role("dialog")).to_be_visible()
    await keyboard.press("Escape")
    await expect(guest.page.get_by_role("dialog")).to_be_hidden()


async def test_the_smallest_screen_shows_all_without_scrolling_sideways(browser: Browser, avatar: Demo) -> None:
    async with visiting(browser, avatar.page, viewport={"width": 360, "height": 740}) as visit:
        await meet(visit)
        assert await visit.read("document.documentElement.scrollWidth") == 360
        assert await visit.read(_BEYOND) == []
        stage = await visit.item("stage").bounding_box()
        assert stage is not None
        assert stage["width"] > 300
        await expect(visit.item("say-send")).to_be_in_viewport()


_REACHED: Final = """(names) => names.filter((name) => {
    const each = document.querySelector(`[data-testid="${name}"]`);
    const { left, top, right, bottom } = each.getBoundingClientRect();
    const inside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
    const [x, y] = [(left + right) / 2, (top + bottom) / 2];
    return !inside || !(document.elementFromPoint(x, y)?.closest(`[data-testid="${name}"]`));
})"""
"""Elements of the page out of reach of a finger: outside of the window, or covered."""


@pytest.mark.parametrize(
    "size",
    [
        (1366, 768),
        (390, 844),
        (844, 390),
        *(pytest.param(size, marks=pytest.mark.long) for size in ((1920, 1080), (768, 1024))),
    ],
    ids="{0[0]}x{0[1]}".format,
)
async def test_stop_picture_and_text_box_stay_wherever_the_page_is_scrolled_to(
    guest: Visit, size: tuple[int, int]
) -> None:
    await guest.page.set_viewport_size({"width": size[0], "height": size[1]})
    staying = ["stop-all", "stage", "say-text", "say-send", "control-toggle", "sound-off", "fullscreen"]
    await guest.page.keyboard.press("Shift")  # any key lets the page sound
    await expect(guest.item("sound-off")).to_be_visible()
    # Of what is under the picture something is in view as well.
    assert await guest.page.evaluate(_REACHED, [*staying, "reaction-1"]) == []
    await guest.page.evaluate("scrollTo(0, document.body.scrollHeight)")
    assert await guest.read("scrollY") > 100
    assert await guest.page.evaluate(_REACHED, staying) == []
    await guest.press("fullscreen")
    await guest.until("document.querySelector(':root:fullscreen') && innerHeight === screen.height")
    assert await guest.page.evaluate(_REACHED, [*staying, "map"]) == []


async def test_layout_stays_when_panels_come_and_go(guest: Visit) -> None:
    names = ["stage", "say-text", "reaction-1", "map"]
    places = f"{names}.map((name) => document.querySelector(`[data-testid=${{name}}]`).getBoundingClientRect().y)"
    before = await guest.read(places)
    for name in ("banner", "handover"):
        await guest.read(f"document.querySelector('[data-testid={name}]').hidden = false")
        await expect(guest.item(name)).to_be_visible()
        assert await guest.read(places) == before


@pytest.mark.parametrize("scheme", [pytest.param("light", marks=pytest.mark.long), "dark"])
async def test_every_text_can_be_read(browser: Browser, avatar: Demo, scheme: str) -> None:
    async with visiting(browser, avatar.page, color_scheme=scheme) as visit:
        await meet(visit)
        await visit.status("video", "RUNNING")
        found = await visit.page.evaluate(_CONTRAST.read_text())
        assert len(found) > 50
        assert [each for each in found if each["ratio"] < _READABLE] == []


@pytest.mark.long
async def test_light_and_dark_are_remembered(guest: Visit) -> None:
    background = "getComputedStyle(document.body).backgroundColor"
    light = await guest.read(background)
    await guest.press("theme-toggle")
    await guest.until(f"{background} !== '{light}'")
    await guest.page.reload()
    assert await guest.read(background) != light


@pytest.mark.long
async def test_puppet_speaks_and_reacts(guest: Visit) -> None:
    await guest.watch("picture", 0.0, 0.0, 1.0, 0.94)
    speech = await speak(guest, "Hello, I am the puppet.")
    assert speech.lasted > 700
    assert speech.liveliness > 2
    assert abs(speech.mouth_after_sound) < 1000
    await guest.page.get_by_role("button", name="Bow").click()
    assert await guest.until("probe.watched.picture.some(({ away }) => away > 2)")
    assert await outcome(guest, "avatar/reaction", "start") == "OK"


@pytest.mark.long
async def test_spoken_word_is_marked_and_held_by_a_pause(guest: Visit) -> None:
    await say(guest, "Green parrots whistle melodies loudly.")
    await guest.until(f"{_MARKED} === 'parrots'")
    await guest.press("say-pause")
    await guest.until(f"{SAYING} === 'paused'")
    await expect(guest.item("say-pause")).to_have_attribute("aria-label", "Go on")
    await guest.press("say-pause")
    await guest.until(f"{_MARKED} === 'loudly'")
    await guest.until(f"{SAYING} === 'done'")
    await expect(guest.item("say-words")).to_be_hidden()
    assert await outcome(guest, "avatar/speech_synthesizer", "suspend") == "OK"


async def test_captions_show_speech_of_any_application_to_every_viewer(avatar: Demo, guest: Visit) -> None:
    caption = guest.item("captions")
    async with Client(avatar.url) as application:
        speech = await application.find(SpeechSynthesis)
        async with speech.bound():
            await speech.set(speech_text="Green parrots whistle melodies loudly, and the others listen.")
            await speech.start().execute()
            await expect(caption).to_have_text(re.compile("^Green parrots whistle melodies loudly"))
            await guest.until("document.querySelector('[data-testid=captions] mark')?.textContent === 'melodies'")
            await guest.press("captions-toggle")
            await expect(caption).to_be_hidden()
            await speech.stop()
    await guest.page.reload()
    await expect(guest.item("captions-toggle")).to_have_attribute("aria-pressed", "false")
    await guest.press("captions-toggle")
    await expect(guest.item("captions-toggle")).to_have_attribute("aria-pressed", "true")


@pytest.mark.long
async def test_completed_waits_for_a_browser_that_buffers_much(guest: Visit) -> None:
    await guest.listen()
    await guest.page.evaluate(_BUFFER)
    await guest.until("openrois.audio.playoutDelay > 550")
    await guest.until_sent("rois.stream.report_playout", lambda report: report["milliseconds"] > 550)
    utterance = await said(guest, "Green parrots whistle loudly.")
    assert utterance.lead < _TOO_EARLY
    assert [word.word for word in utterance.words] == ["Green", "parrots", "whistle", "loudly"]


async def test_stop_silences_what_the_browser_has_buffered(guest: Visit) -> None:
    await guest.listen()
    await say(guest, "Once upon a time there was an avatar that told long stories to all its visitors.")
    await aloud(guest)
    assert await guest.read(f"[{PRESS_STOP}, openrois.audio.track.enabled][1]") is False
    await guest.until(f"{SAYING} === 'stopped'")
    await expect(guest.item("say-state")).to_contain_text("stopped at the word")
    await guest.until("openrois.audio.track.enabled")  # the buffer has run out
    await guest.until(f"probe.sound.slice(-20).every(({{ rms }}) => rms < {AUDIBLE})")


async def test_stop_right_after_start_ends_the_speech(guest: Visit) -> None:
    await guest.listen()
    for milliseconds in (0, 5, 20, 60):
        await guest.item("say-text").fill("Once upon a time there was an avatar that told long stories.")
        await guest.page.evaluate(_START_AND_STOP, milliseconds)
        await guest.until(f"{SAYING} === 'stopped'")
        assert await guest.read(f"{SAYING}") == "stopped"
    stops = len(guest.executed("avatar/speech_synthesizer", "stop"))
    assert stops <= 4
    ended = await guest.read("performance.now()")
    await guest.until(f"probe.sound.at(-1).at > {ended} + 1000")
    assert await guest.read(f"probe.sound.slice(-30).every(({{ rms }}) => rms < {AUDIBLE})")
    assert len(guest.executed("avatar/speech_synthesizer", "stop")) == stops


def _spoken(visit: Visit) -> list[tuple[str, str]]:
    """Return what the page asked the avatar to speak so far, and as which parameter."""
    return [
        (argument["name"], argument["value"])
        for message in visit.sent
        if message["method"] == "rois.command.execute"
        for unit in message["params"]["command_unit_list"]
        for argument in unit.get("arguments", [])
        if argument["name"] in {"speech_text", "ssml_text"}
    ]


@pytest.mark.long
async def test_queued_sentences_are_shown_and_removed(guest: Visit) -> None:
    first = "First of all an avatar that is about to be interrupted says what takes it a few seconds."
    await say(guest, first)
    await guest.press("say-pause")  # so that nothing comes to its end while the list is looked at
    await guest.until(f"{SAYING} === 'paused'")
    for text in ("Second.", "Third."):
        await say(guest, text)
        await expect(guest.item("say-text")).to_have_value("")
    waiting = guest.item("say-queue").get_by_role("listitem")
    await expect(waiting).to_have_count(2)
    await guest.page.get_by_role("button", name="Remove “Second.”").click()
    await expect(waiting).to_have_count(1)
    await guest.press("say-pause")
    await guest.until(f"{SAYING} === 'done' && document.querySelector('[data-testid=say-queue]').hidden")
    texts = [value for _, value in _spoken(guest)]
    assert texts == [first, "Third."]


@pytest.mark.long
async def test_a_long_text_loses_nothing_and_ssml_is_spoken_without_its_tags(guest: Visit) -> None:
    long = " ".join(f"Sentence number {number}." for number in range(250))
    await guest.item("say-text").fill(long)
    await guest.item("say-text").press("Enter")
    await guest.until_executed("avatar/speech_synthesizer", "start")
    [(_, spoken)] = _spoken(guest)
    assert len(spoken) <= 4000
    rest = await guest.item("say-queue").locator("span").inner_text()
    assert f"{spoken} {rest}" == long
    await guest.press("say-stop")
    await guest.until(f"{SAYING} === 'stopped'")
    await expect(guest.item("say-queue")).to_be_hidden()

    await say(guest, "<speak>Parrots <emphasis>whistle</emphasis> loudly.</speak>")
    await guest.until(f"{_MARKED} === 'whistle'")
    await expect(guest.item("say-words")).to_have_text("Parrots whistle loudly.")
    await guest.until(f"{SAYING} === 'done'")


async def test_language_is_named_and_kept_and_warns_of_unreadable_text(guest: Visit) -> None:
    language, hint = guest.item("say-language"), guest.item("say-hint")
    await expect(language).to_be_visible()
    names = await language.locator("option").all_inner_texts()
    assert len(names) > 100
    assert [name for name in names if not name[0].isupper()] == []
    await guest.item("say-text").fill("漢字")
    await expect(hint).to_contain_text("“漢字” may be spelled out")
    await language.select_option(label="Chinese")
    await expect(hint).to_be_hidden()
    await guest.page.reload()
    await expect(language).to_have_value("zh")
    assert await language.locator("optgroup").first.get_attribute("label") == "Recent"
