"""Every body speaks the sound of an application, or refuses it with a reason: real gateway, adapter and WebRTC."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from openrois_media import Media
from openrois_robots.reachy.adapter import hosted_reachy
from openrois_signaling.messages import Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.input.speech import Begin, Frame, Refused, pack_frame, read_told
from openrois_streaming.testing import MeasuringSink
from websockets.asyncio.client import connect

from openrois.adapter.dialer import serve_parent
from openrois.client import Client, Unsupported
from openrois.client.components import SpeechSynthesis
from tests.robots.ros2 import test_simulated_robot as ros2
from tests.robots.simulated import test_streams as rooms
from tests.support import reachy
from tests.support.deployment import Application, gateway
from tests.support.kachaka_home import home
from tests.support.operated import operated_avatar

pytestmark = pytest.mark.media

PATIENCE = 60.0


@asynccontextmanager
async def avatar(folder: Path) -> AsyncIterator[str]:
    async with operated_avatar(folder) as (running, _):
        yield running.url.replace("http", "ws")


@asynccontextmanager
async def simulated(_folder: Path) -> AsyncIterator[str]:
    async with rooms.house() as house:
        yield house.url


@asynccontextmanager
async def kachaka(_folder: Path) -> AsyncIterator[str]:
    async with home() as house:
        yield house.url


@asynccontextmanager
async def ros2_robot(_folder: Path) -> AsyncIterator[str]:
    async with ros2.house() as house, ros2.simulated(house):
        await house.ready()
        yield house.url


@asynccontextmanager
async def reachy_mini(_folder: Path) -> AsyncIterator[str]:
    async with (
        gateway() as running,
        reachy.simulated(has_media=True) as (_, address),
        reachy.linked(address) as robot,
        hosted_reachy("robot", robot, SystemClock()) as served,
    ):
        url = running.url.replace("http", "ws", 1)
        there = asyncio.Event()
        serving = asyncio.create_task(serve_parent(served.host, f"{url}adapter", attached=lambda _: there.set()))
        try:
            async with asyncio.timeout(PATIENCE):
                await there.wait()
            yield url
        finally:
            serving.cancel()
            await asyncio.wait({serving})


@dataclass(frozen=True)
class Body:
    """A body behind a gateway.

    Attributes:
        running: runs it, with the gateway; yields the address.
        engine_id: of the body.
        plays: whether it plays the sound of an application.
        carrier: a streaming component, over whose peer connection an application would send; empty: there is none.
        refusal: what a body that does not play says of that.
    """

    running: Callable[[Path], AbstractAsyncContextManager[str]]
    engine_id: str = "robot"
    plays: bool = False
    carrier: str = ""
    refusal: str = ""


BODIES = {
    "avatar": Body(avatar, "avatar", plays=True),
    "simulated robot": Body(simulated, plays=True),
    "Kachaka": Body(
        kachaka, "kachaka", carrier="kachaka/video_streaming", refusal="a Kachaka plays no sound that is sent to it"
    ),
    "ROS 2": Body(
        ros2_robot, carrier="robot/video_streaming", refusal="a robot that speaks ROS 2 takes texts and no sound"
    ),
    "Reachy Mini": Body(reachy_mini),
}


@pytest.fixture(params=[pytest.param(body, id=name) for name, body in BODIES.items()])
def body(request: pytest.FixtureRequest) -> Body:
    found: Body = request.param
    return found


async def test_it_plays_and_tells_how_far_or_says_that_it_does_not(body: Body, tmp_path: Path) -> None:
    async with body.running(tmp_path) as url, asyncio.timeout(PATIENCE), Client(url) as client, Media(client) as media:
        if body.plays:
            async with media.speech(body.engine_id, rate=16_000) as speech:
                await speech.push(np.full(20_000, 0.3))
                # More than a second is only taken when some of it was played.
                assert speech.played > 0.1
                spoken = await speech.finish()
            assert (spoken.seconds, spoken.reason) == (1.25, "")
            return
        with pytest.raises(Unsupported, match=f"no component of {body.engine_id} speaks by sound: .*SpeechSynthesis"):
            async with media.speech(body.engine_id):
                pass
        spoken_by = [each.component_ref for each in await client.find_all(SpeechSynthesis)]
        assert spoken_by == [f"{body.engine_id}/speech_synthesizer"]


@pytest.mark.parametrize("name", [name for name, each in BODIES.items() if each.carrier])
async def test_what_is_sent_to_one_that_does_not_play_is_refused_with_the_reason(name: str, tmp_path: Path) -> None:
    body = BODIES[name]
    async with (
        body.running(tmp_path) as url,
        asyncio.timeout(PATIENCE),
        MeasuringSink() as sink,
        connect(url, max_queue=None) as socket,
    ):
        app = Application(socket)
        await app.ask("openrois.hello", version="1", extensions=[])
        wish = json.dumps({"direction": "recvonly", "speech": True})
        parameter = {"name": "transport_parameters", "data_type_ref": "String", "value": wish}
        connected = await app.code("rois.stream.connect_stream", component_ref=body.carrier, parameters=[parameter])
        assert connected == "OK"
        offer = Offer.model_validate(await app.next("signaling.offer"))
        assert await app.code("signaling.answer", **(await sink.respond(offer)).wire()) == "OK"
        await sink.until(lambda: sink.input is not None and sink.input.are_open)
        assert sink.input is not None
        channels = sink.input
        channels.speak(json.dumps(Begin(1, "pcm16", 16_000).to_json()))
        channels.speak(pack_frame(Frame(1, 0, bytes(2_000))))
        await sink.until(lambda: channels.told)
        (told,) = map(read_told, channels.told)
        assert isinstance(told, Refused)
        assert told.reason.startswith(body.refusal)
        assert "use its speech_synthesizer" in told.reason
