"""An agent hears the visitor whom a real avatar attends to, as far as that visitor consents."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_agents.voice.visitor_sound import MAX_UNHEARD, VisitorSound
from openrois_media import Media
from openrois_streaming.source.source import RawAudio

from openrois.client import Client, Unsupported
from openrois.types.codes import Purpose
from tests.support.loopback import PATIENCE
from tests.support.media_body import body as plain_body
from tests.support.operated import operated_avatar
from tests.support.sounds import paced

pytestmark = pytest.mark.media

AGENT = Purpose.AGENT
BOTH = (AGENT, Purpose.LIVE)
LOW, HIGH = 400.0, 1_300.0


class Whistle:
    """Sound of a visitor: a tone without an end, of a pitch by which it is known."""

    def __init__(self, pitch: float) -> None:
        self._pitch = pitch

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        yield paced(self._block)

    def _block(self, number: int) -> NDArray[np.int16]:
        place = (np.arange(960) + number * 960) / 48_000
        wave = (np.sin(2 * np.pi * self._pitch * place) * 8_000).astype(np.int16)
        return np.column_stack([wave, wave])


@asynccontextmanager
async def program(url: str) -> AsyncIterator[tuple[Client, Media]]:
    async with asyncio.timeout(PATIENCE), Client(url) as client, Media(client) as media:
        yield client, media


@pytest.fixture
async def url(tmp_path: Path) -> AsyncIterator[str]:
    async with operated_avatar(tmp_path) as (running, _):
        yield running.url.replace("http", "ws")


async def until(so: Callable[[], object]) -> None:
    """Wait for what is not announced."""
    async with asyncio.timeout(PATIENCE):
        while not so():  # noqa: ASYNC110 - see above
            await asyncio.sleep(0.01)


async def until_heard(sound: VisitorSound, visitor_ref: str) -> None:
    await until(lambda: sound.heard == visitor_ref)


async def refs(media: Media) -> list[str]:
    """Return the visitors, the first that came first."""
    return [each.visitor_ref for each in await media.visitors("avatar", purposes=[AGENT])]


async def pitch_of(sound: VisitorSound, visitor_ref: str) -> float:
    """Return the pitch of half a second of a visitor's sound; nothing else comes meanwhile."""
    while not (first := await anext(sound)).visitor_ref:
        assert not first.samples.any()
    blocks = [first, *[await anext(sound) for _ in range(24)]]
    assert {each.visitor_ref for each in blocks} == {visitor_ref}
    samples = np.concatenate([each.samples for each in blocks])
    assert samples.dtype == np.int16
    spectrum = np.abs(np.fft.rfft(samples))
    return float(spectrum.argmax() * sound.rate / len(samples))


@pytest.mark.parametrize("rate", [16_000, 24_000])
async def test_a_visitor_that_consents_is_heard_at_the_rate_that_is_wanted(url: str, rate: int) -> None:
    async with program(url) as (client, media), program(url) as (_, theirs):
        async with VisitorSound(client, media, "avatar/reaction", purposes=[AGENT], rate=rate) as sound:
            heard: list[str] = []
            sound.heard_changed.add(heard.append)
            async with theirs.send(microphone=Whistle(LOW), consent=[AGENT]):
                await until(lambda: sound.heard)
                (visitor_ref,) = await refs(media)
                assert sound.heard == visitor_ref
                assert await pitch_of(sound, sound.heard) == pytest.approx(LOW, abs=20)
            await until(lambda: not sound.heard)
            assert heard == [visitor_ref, ""]
        with pytest.raises(StopAsyncIteration):
            await anext(sound)


async def test_nothing_comes_of_a_visitor_from_the_withdrawal_of_its_consent_on_until_it_is_given_again(
    url: str,
) -> None:
    async with (
        program(url) as (client, media),
        program(url) as (_, theirs),
        theirs.send(microphone=Whistle(LOW), consent=BOTH) as sending,
        VisitorSound(client, media, "avatar", purposes=[AGENT]) as sound,
    ):
        # A second of sound waits for a slow agent, and no more.
        await until(lambda: len(sound._blocks) == MAX_UNHEARD)
        withdrawn = asyncio.Event()
        sound.heard_changed.add(lambda ref: None if ref else withdrawn.set())
        await sending.consent(Purpose.LIVE)
        await withdrawn.wait()
        # The agent's ears are given silence, and then nothing.
        for _ in range(25):
            silence = await anext(sound)
            assert (silence.visitor_ref, silence.samples.any()) == ("", False)
        next_block = asyncio.ensure_future(anext(sound))
        # The body goes on to take the sound, for what is still consented to.
        present = await media.visitors("avatar", purposes=[AGENT])
        assert present[0].consent == {"live"}
        assert not next_block.done()
        await sending.consent(AGENT)
        assert (await next_block).visitor_ref == sending.visitor_ref


async def test_it_follows_the_visitor_whom_the_body_attends_to(url: str) -> None:
    async with (
        program(url) as (client, media),
        program(url) as (_, first),
        program(url) as (_, second),
        first.send(microphone=Whistle(LOW), consent=BOTH),
        second.send(microphone=Whistle(HIGH), consent=BOTH),
        VisitorSound(client, media, "avatar", purposes=[AGENT]) as sound,
    ):
        visitors = client.component("avatar/visitors")
        one, other = await refs(media)
        for wanted, pitch in ((one, LOW), (other, HIGH), (one, LOW)):
            await visitors.set_parameter(attention=wanted)
            await until_heard(sound, wanted)
            assert await pitch_of(sound, wanted) == pytest.approx(pitch, abs=20)


async def test_a_visitor_that_does_not_consent_to_every_purpose_is_not_heard(url: str) -> None:
    async with (
        program(url) as (client, media),
        program(url) as (_, theirs),
        theirs.send(microphone=Whistle(LOW), consent=[AGENT]) as sending,
        VisitorSound(client, media, "avatar", purposes=[AGENT, Purpose.TRANSFER]) as sound,
    ):
        changes = client.component("avatar/visitors").event("visitor_changed")
        async with changes:
            await sending.consent(*BOTH)
            await anext(changes)
            assert sound.heard == ""
            await sending.consent(AGENT, Purpose.TRANSFER)
        await until_heard(sound, sending.visitor_ref)


async def test_a_body_that_tells_no_visitors_apart_and_what_is_impossible_are_named() -> None:
    async with plain_body() as robot, program(robot.url) as (client, media):
        with pytest.raises(Unsupported, match="robot tells no visitors apart"):
            async with VisitorSound(client, media, "robot", purposes=[AGENT]):
                pass
        with pytest.raises(ValueError, match="give one purpose at least"):
            async with VisitorSound(client, media, "robot", purposes=[]):
                pass
        with pytest.raises(ValueError, match="use one of 8000, 16000, 24000, 48000"):
            VisitorSound(client, media, "robot", purposes=[AGENT], rate=44_100)
