"""The example of the guide, as a person runs it, without a network."""

import asyncio
import re
import signal
import sys
from pathlib import Path

import pytest
from openrois_media import Media

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.support.loopback import PATIENCE
from tests.support.operated import operated_avatar
from tests.support.packages import ROOT
from tests.support.voice_agents import Mouth, hearing

pytestmark = [pytest.mark.agents, pytest.mark.media]


async def test_the_parrot_repeats_what_a_visitor_says(tmp_path: Path) -> None:
    async with operated_avatar(tmp_path) as (running, _), asyncio.timeout(2 * PATIENCE):
        url = running.url.replace("http", "ws")
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            ROOT / "docs/examples/pipecat_agent.py",
            "avatar",
            url,
            stdout=asyncio.subprocess.PIPE,
        )
        assert process.stdout is not None
        mouth = Mouth()
        try:
            async with (
                Client(url) as client,
                Media(client) as media,
                hearing(media) as ear,
                media.send(microphone=mouth, consent=[Purpose.AGENT]),
            ):
                # The program may not listen yet: it is spoken to until it has heard.
                answer = asyncio.ensure_future(process.stdout.readline())
                while not answer.done():
                    mouth.say(500, 0.6)
                    await mouth.until_said()
                    await asyncio.wait({answer}, timeout=2)
                # It may have begun to listen in the middle of a tone.
                said = re.fullmatch(r"(\d\.\d) s of sound\n", (await answer).decode())
                assert said
                assert 0 < float(said[1]) < 1
                await ear.until_loud(0.05)
                assert ear.heard[0].pitch == pytest.approx(500, abs=100)
        finally:
            process.send_signal(signal.SIGINT)
            await process.wait()
