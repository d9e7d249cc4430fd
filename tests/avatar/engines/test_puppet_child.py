"""The puppet as it really runs: a child process on the engine link."""

import asyncio

import cv2
import numpy as np
import pytest
from openrois_avatar.child import Output, child_process, ended_within
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.messages import Completed, Event, React
from openrois_avatar.link.server import LinkServer
from openrois_streaming.clock import SystemClock
from openrois_streaming.source import RawAudio

pytestmark = pytest.mark.engine

MODULE = "openrois_avatar.engines.puppet"


async def test_it_sends_pictures_and_sound_obeys_and_ends_with_its_link() -> None:
    clock, events, sound = SystemClock(), asyncio.Queue[Event](), asyncio.Queue[RawAudio]()
    output = Output(MODULE, clock)
    listening = LinkServer.listen(on_audio=sound.put_nowait, on_event=events.put_nowait, clock=clock)
    async with asyncio.timeout(25), listening as server:
        environment = {ADDRESS_VARIABLE: server.address, SECRET_VARIABLE: server.secret}
        async with child_process(MODULE, output=output, environment=environment) as process:
            engine = await server.accept(20)
            assert engine.hello.name == "puppet"
            assert engine.hello.reactions == tuple(REACTIONS)
            engine.send_command(React("1", "nod"))
            pictures = []
            async with server.video.open() as frames:
                async for frame in frames:
                    pictures.append(frame)
                    if len(pictures) == 30:
                        break
            assert await events.get() == Completed("1", "OK")
            assert (await sound.get()).samples.shape == (960, 1)
            engine.close("enough")
            assert await ended_within(process, 3)
            assert process.returncode == 0, output.last_words
    assert [picture.sequence for picture in pictures] == sorted({picture.sequence for picture in pictures})
    assert all((picture.width, picture.height, picture.format) == (640, 360, "i420") for picture in pictures)
    shown = cv2.cvtColor(np.asarray(pictures[-1].data).reshape(540, 640), cv2.COLOR_YUV2BGR_I420)
    assert float(shown.std()) > 20
