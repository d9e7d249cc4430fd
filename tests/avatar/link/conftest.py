"""A link server with a clock that tests turn."""

from collections.abc import AsyncIterator

import pytest
from openrois_avatar.link.messages import Event
from openrois_avatar.link.server import LinkServer
from openrois_streaming.source.source import RawAudio

from tests.support.link_world import World
from tests.support.streaming import VirtualClock


@pytest.fixture
async def world() -> AsyncIterator[World]:
    audio, events = list[RawAudio](), list[Event]()
    clock = VirtualClock(now=1000)
    async with LinkServer.listen(on_audio=audio.append, on_event=events.append, clock=clock) as server:
        world = World(server, audio, events)
        yield world
    for engine in world.engines:
        await engine.aclose()
