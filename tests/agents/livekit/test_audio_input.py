"""The ears of a session, without a session: what they let pass."""

import asyncio

import numpy as np
import pytest
from openrois_agents.livekit.audio_input import VisitorAudioInput
from openrois_agents.voice.visitor_sound import VisitorBlock, VisitorSound
from openrois_media import Media

from openrois.client import Client
from openrois.types.codes import Purpose

pytestmark = [pytest.mark.agents, pytest.mark.extra(name="livekit")]


async def test_what_comes_while_the_input_is_off_is_dropped() -> None:
    client = Client("ws://127.0.0.1:9/")
    sound = VisitorSound(client, Media(client), "avatar", purposes=[Purpose.AGENT])
    ears = VisitorAudioInput(sound)

    def hear(value: int) -> None:
        sound._blocks.append(VisitorBlock("visitor", np.full(320, value, np.int16)))
        sound._news.notify()

    hear(1)
    reading = asyncio.ensure_future(anext(ears))
    await asyncio.wait({reading}, timeout=0.1)
    assert not sound._blocks
    ears.on_attached()
    hear(2)
    frame = await reading
    assert (frame.sample_rate, frame.num_channels, frame.samples_per_channel) == (16_000, 1, 320)
    assert set(np.frombuffer(frame.data, np.int16)) == {2}
    hear(3)
    ears.on_detached()
    reading = asyncio.ensure_future(anext(ears))
    await asyncio.wait({reading}, timeout=0.1)
    assert not sound._blocks
    ears.on_attached()
    hear(4)
    assert set(np.frombuffer((await reading).data, np.int16)) == {4}
