"""What only a real browser shows: how Chromium answers, reports and goes away."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from openrois_streaming.errors import InvalidDescription, UnexpectedAnswer
from openrois_streaming.state import StreamStatus
from openrois_streaming.testing import ImpairedPath, Impairments
from playwright.async_api import Browser

from tests.support import loopback
from tests.support.chromium import Tab, browser_at, tab
from tests.support.loopback import Engine

pytestmark = [
    pytest.mark.browser,
    pytest.mark.long,
    pytest.mark.asyncio(loop_scope="module"),
]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser(chromium: Path) -> AsyncIterator[Browser]:
    async with browser_at(chromium) as browser:
        yield browser


@pytest_asyncio.fixture(loop_scope="module")
async def engine() -> AsyncIterator[Engine]:
    async with loopback.engine() as engine:
        yield engine


@pytest_asyncio.fixture(loop_scope="module")
async def page(engine: Engine, browser: Browser) -> AsyncIterator[Tab]:
    async with tab(engine, browser) as page:
        yield page


async def test_a_person_sees_and_hears_although_the_browser_hides_its_addresses(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    engine.connect("a", "audio")
    await page.plays("0", 1)
    await page.hears("1")
    assert page.candidates
    assert all(".local" in candidate for candidate in page.candidates)
    assert page.refusals == []
    assert engine.failures == []
    await engine.until("v", StreamStatus.RUNNING)
    await engine.until("a", StreamStatus.RUNNING)


async def test_trap_9_sound_plays_when_its_track_is_also_in_a_media_element(engine: Engine, page: Tab) -> None:
    engine.connect("a", "audio")
    await engine.until("a", StreamStatus.RUNNING, 2.0)
    await page.hears("0")


async def test_sound_alone_keeps_running_although_the_browser_reports_seldom(browser: Browser) -> None:
    async with loopback.engine(speed=8.0) as engine, tab(engine, browser) as page:
        engine.connect("a", "audio")
        await engine.until("a", StreamStatus.RUNNING)
        await page.hears("0")
        with pytest.raises(TimeoutError):
            await engine.news.until(lambda: engine.byes, 1.3)
        assert engine.byes == []


async def test_trap_2_two_sections_where_only_the_browsers_own_candidates_work(engine: Engine, chromium: Path) -> None:
    async with browser_at(chromium, hide_addresses=False) as browser, tab(engine, browser) as page:
        page.pass_offered_candidates = False
        engine.connect("v", "video")
        engine.connect("a", "audio")
        await page.plays("0")
        await page.hears("1")
        assert page.candidates
        assert page.refusals == []


async def test_suspend_keeps_the_last_picture_and_resume_needs_no_negotiation(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    await page.plays()
    engine.session.suspend("v")
    await engine.until("v", StreamStatus.SUSPENDED)
    await page.page.wait_for_timeout(300)
    still = await page.frames()
    await page.page.wait_for_timeout(500)
    assert await page.frames() == still
    brightest = await page.page.evaluate(
        """() => { const canvas = new OffscreenCanvas(64, 36), pen = canvas.getContext('2d');
                   pen.drawImage(media['0'], 0, 0, 64, 36);
                   return Math.max(...pen.getImageData(0, 0, 64, 36).data.filter((_, i) => i % 4 < 3)); }"""
    )
    assert brightest > 100
    engine.session.resume("v")
    await page.plays()
    await engine.until("v", StreamStatus.RUNNING)
    assert len(engine.offers) == 1


async def test_trap_4_a_section_goes_idle_and_plays_again(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    await page.plays()
    engine.session.disconnect("v")
    await page.page.wait_for_function("media['0'].srcObject.getTracks()[0].muted")
    assert await page.page.evaluate("media['0'].srcObject.getTracks()[0].readyState") == "live"
    engine.connect("w", "video")
    await page.plays()
    assert engine.byes == []


async def test_trap_3_a_section_that_the_browser_rejects_ends_that_peer_only(engine: Engine, page: Tab) -> None:
    page.bend = """
        const vp9 = RTCRtpReceiver.getCapabilities('video').codecs.filter(c => c.mimeType == 'video/VP9');
        pc.getTransceivers()[0].setCodecPreferences(vp9);"""
    engine.connect("v", "video")
    engine.connect("a", "audio")
    await engine.news.until(lambda: page.refusals)
    assert isinstance(page.refusals[0], InvalidDescription)
    assert [bye.reason for bye in engine.byes] == ["the video section 0 was rejected"]
    page.bend = ""
    engine.connect("w", "video")
    await page.plays()


async def test_trap_8_a_stale_answer_of_equal_size_is_dropped(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    await page.plays()
    engine.application = None
    engine.session.disconnect("v")
    await engine.news.until(lambda: len(engine.offers) == 2)
    old = await page.page.evaluate("Object.values(peers)[0].localDescription.sdp")
    with pytest.raises(UnexpectedAnswer):
        await engine.answer(engine.offers[0], old)
    await page.respond(engine.offers[1])
    assert page.refusals == []
    assert engine.byes == []


async def test_a_browser_that_can_only_vp8_gets_vp8(engine: Engine, page: Tab) -> None:
    page.bend = """
        const vp8 = RTCRtpReceiver.getCapabilities('video').codecs.filter(c => /VP8|rtx/.test(c.mimeType));
        pc.getTransceivers()[0].setCodecPreferences(vp8);"""
    engine.connect("v", "video")
    await page.plays()
    assert (await engine.session.stats("v")).codec == "video/VP8"


async def test_a_replacement_plays_beside_the_old_one(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    await page.plays()
    engine.session.restart("engine/p1")
    await engine.news.until(lambda: engine.byes)
    assert [(bye.peer_id, bye.reason) for bye in engine.byes] == [("engine/p1", "it was replaced")]
    await page.plays()
    assert StreamStatus.NOT_CONNECTED not in engine.statuses("v")


async def test_losses_are_repaired_and_a_burst_costs_few_key_frames(engine: Engine, page: Tab) -> None:
    async with ImpairedPath(Impairments(loss=0.05, delay=0.01), Impairments(delay=0.01)) as path:
        page.path = path
        engine.connect("v", "video")
        await page.plays("0", 30)
        before = await engine.session.stats("v")
        assert before.packets_retransmitted > 0
        # A repeated packet may be lost too, and costs a key frame by chance: the burst is counted alone.
        path.down.change(loss=0.0)
        path.down.lose_next(40)
        await page.plays("0", 20)
        assert path.down.figures().lost > 40
    after = await engine.session.stats("v")
    assert after.key_frames - before.key_frames <= 2
    assert after.key_frame_requests - before.key_frame_requests <= 10


async def test_a_closed_tab_is_noticed_long_before_the_consent_to_send_expires(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    engine.connect("a", "audio")
    await page.plays()
    await engine.until("v", StreamStatus.RUNNING)
    engine.application = None
    await page.page.close()
    await engine.until("v", StreamStatus.NOT_CONNECTED, 15.0)
    assert [bye.reason for bye in engine.byes] == ["the viewer is gone"]
    assert engine.session.stream_ids == ()


async def test_trap_10_a_page_that_is_left_is_noticed_at_once(engine: Engine, page: Tab) -> None:
    engine.connect("v", "video")
    await page.plays()
    engine.application = None
    await page.page.evaluate("Object.values(peers)[0].close()")
    await engine.until("v", StreamStatus.NOT_CONNECTED, 1.0)
    assert [bye.reason for bye in engine.byes] == ["the application closed the peer connection"]
