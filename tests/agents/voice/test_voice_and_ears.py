"""The voice and the ears of a real avatar, opened together."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from openrois_agents.voice.voice_and_ears import open_voice_and_ears
from openrois_media import Media
from openrois_media.client.speaking import Spoken

from openrois.client import Client, OutOfResources, Unsupported
from openrois.types.codes import Purpose
from tests.support.loopback import PATIENCE
from tests.support.media_body import body as plain_body
from tests.support.operated import operated_avatar
from tests.support.sounds import tone
from tests.support.voice_agents import Mouth, hearing

pytestmark = pytest.mark.media

PITCH = 600.0


@pytest.fixture
async def url(tmp_path: Path) -> AsyncIterator[str]:
    async with operated_avatar(tmp_path) as (running, _), asyncio.timeout(2 * PATIENCE):
        yield running.url.replace("http", "ws")


async def test_the_body_speaks_what_is_written_and_its_visitor_is_heard(url: str) -> None:
    ends: list[Spoken] = []
    async with (
        Client(url) as client,
        Media(client) as media,
        hearing(media) as ear,
        media.send(microphone=Mouth(), consent=[Purpose.AGENT]),
        open_voice_and_ears(client, media, "avatar", [Purpose.AGENT]) as (writer, sound),
    ):
        assert sound is not None
        assert (writer.rate, sound.rate) == (24_000, 16_000)
        writer.finished.add(ends.append)
        await writer.write(tone(0.4, writer.rate, PITCH))
        writer.end_utterance()
        await writer.until_over()
        assert ends == [Spoken(0.4)]
        await ear.until_quiet()
        # A busy machine may lose some of it on the way.
        assert 0.05 < ear.seconds(PITCH) < 0.5
        while not (await anext(sound)).visitor_ref:
            pass
        (visitor,) = await media.visitors("avatar", purposes=[Purpose.AGENT])
        assert sound.heard == visitor.visitor_ref
        with pytest.raises(OutOfResources):
            async with Client(url) as other, Media(other) as others, open_voice_and_ears(other, others, "avatar", []):
                pass
        await writer.write(tone(1.5, writer.rate, PITCH))
        assert await writer.until_heard(writer.mark().after(-1.0))
    assert len(ends) == 2
    assert ends[1].interrupted
    assert ends[1].seconds < 1.5
    with pytest.raises(StopAsyncIteration):
        await anext(sound)


async def test_without_a_purpose_nothing_is_heard(url: str) -> None:
    async with Client(url) as client, Media(client) as media:
        async with open_voice_and_ears(client, media, "avatar", []) as (writer, sound):
            assert sound is None
            await writer.write(tone(0.1, writer.rate))
            writer.end_utterance()
            await writer.until_over()
        # The voice is given back.
        async with open_voice_and_ears(client, media, "avatar", []):
            pass


async def test_a_body_without_a_voice_is_refused() -> None:
    async with plain_body() as robot, asyncio.timeout(PATIENCE), Client(robot.url) as client, Media(client) as media:
        with pytest.raises(Unsupported):
            async with open_voice_and_ears(client, media, "robot", [Purpose.AGENT]):
                pass
