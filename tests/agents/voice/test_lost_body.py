"""A body that is lost and comes back: the same writer and the same ears go on with it."""

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
from openrois_agents.voice.speech_writer import SpeechWriter
from openrois_agents.voice.visitor_sound import VisitorSound
from openrois_media import Media
from openrois_media.client.speaking import Spoken

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.support.deployment import gateway, until
from tests.support.loopback import PATIENCE
from tests.support.operated import noting_avatar
from tests.support.sounds import tone
from tests.support.voice_agents import Mouth

pytestmark = pytest.mark.media

RATE = 24_000


async def test_utterances_and_visitors_are_heard_again_when_the_body_is_back(tmp_path: Path) -> None:
    ends: list[Spoken] = []
    heard: list[str] = []
    async with gateway() as running, AsyncExitStack() as avatar, asyncio.timeout(2 * PATIENCE):
        url = running.url.replace("http", "ws", 1)
        await avatar.enter_async_context(noting_avatar(tmp_path, f"{url}adapter"))
        await until(running.engine, lambda ids: "avatar" in ids)
        async with (
            Client(url) as client,
            Media(client) as media,
            media.send(microphone=Mouth(), consent=[Purpose.AGENT]),
            VisitorSound(client, media, "avatar", purposes=[Purpose.AGENT]) as sound,
            media.speech("avatar", rate=RATE) as speech,
            SpeechWriter(speech) as writer,
        ):
            writer.finished.add(ends.append)
            sound.heard_changed.add(heard.append)
            while not (await anext(sound)).visitor_ref:
                pass
            writing = asyncio.create_task(writer.write(tone(6.0, RATE)))
            while not writer.position:
                await anext(sound)
            await avatar.aclose()
            await writing
            writer.end_utterance()
            await writer.until_over()
            assert ends[0].interrupted

            await avatar.enter_async_context(noting_avatar(tmp_path, f"{url}adapter"))
            while ends[-1].interrupted:
                await writer.write(tone(0.2, RATE))
                writer.end_utterance()
                await writer.until_over()
            assert ends[-1] == Spoken(0.2)
            while not (await anext(sound)).visitor_ref:
                pass
            assert [bool(ref) for ref in heard][-2:] == [False, True]
            assert heard[-1] != heard[0]
