"""The simulated robot behind a real gateway: its picture over WebRTC, its voice, and what it sees of persons."""

import asyncio
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

import numpy as np
import pytest
from openrois_media import Media
from openrois_robots.simulated.adapter import AUDIO, VIDEO, Robot, hosted_robot, simulated_robot
from openrois_robots.simulated.camera import RobotCamera
from openrois_robots.simulated.simulation import SimulationSettings
from openrois_robots.simulated.world.plan import APARTMENT, Plan
from openrois_streaming.clock import SystemClock

from openrois.adapter.dialer import serve_parent
from openrois.client import Client
from openrois.client.components import PersonDetection, PersonLocalization, SpeechSynthesis
from tests.support.black_box import Application, application
from tests.support.deployment import gateway
from tests.support.simulated_robot import at

pytestmark = pytest.mark.media

BEFORE_CLERK = at(0.99, -1.17, -0.54)
"""Two metres before the clerk, who is alone in the picture."""


@dataclass
class House:
    """A robot behind a gateway."""

    robot: Robot
    url: str

    @asynccontextmanager
    async def guest(self) -> AsyncIterator[Application]:
        async with application(self.url) as app:
            await app.hello()
            yield app


@asynccontextmanager
async def house(plan: Plan = APARTMENT) -> AsyncIterator[House]:
    clock = SystemClock()
    async with (
        gateway() as running,
        simulated_robot("robot", SimulationSettings(), clock, plan) as robot,
        hosted_robot("robot", robot, clock) as served,
    ):
        url = running.url.replace("http", "ws", 1)
        there = asyncio.Event()
        serving = asyncio.create_task(serve_parent(served.host, f"{url}adapter", attached=lambda _: there.set()))
        try:
            async with asyncio.timeout(30):
                await there.wait()
            yield House(robot, url)
        finally:
            serving.cancel()
            await asyncio.wait({serving})


async def closed(camera: RobotCamera) -> None:
    """Wait until nothing is drawn any more."""
    async with asyncio.timeout(30):
        while camera.is_open:  # noqa: ASYNC110 - it tells of no event
            await asyncio.sleep(0)


async def test_a_viewer_sees_the_rooms_and_without_one_nothing_is_drawn() -> None:
    async with house() as home, home.guest() as app:
        assert home.robot.camera.drawn == 0
        stream_id = await app.play(f"robot/{VIDEO}")
        await app.frames(stream_id, 5)
        seen = app.media(stream_id).luma
        assert seen is not None
        assert seen.shape == (360, 640)
        assert seen.std() > 20
        await app.act("disconnect", stream_id)
        await closed(home.robot.camera)
        assert home.robot.camera.drawn >= 5


async def test_its_voice_is_heard() -> None:
    async with house() as home, home.guest() as app, Client(home.url) as client:
        stream_id = await app.play(f"robot/{AUDIO}")
        await app.news.until(lambda: app.media(stream_id).blocks > 10)
        assert np.abs(app.media(stream_id).sound()).max() < 0.01, "its motors are silent"
        speech = await client.find(SpeechSynthesis)
        async with speech.bound():
            await speech.set(speech_text="Hello", volume=100)
            await client.run(speech.start())
        assert np.abs(app.media(stream_id).sound()).max() > 0.05


async def test_it_speaks_the_sound_of_an_application() -> None:
    async with house() as home, home.guest() as app, Client(home.url) as client, Media(client) as media:
        stream_id = await app.play(f"robot/{AUDIO}")
        await app.news.until(lambda: app.media(stream_id).blocks > 10)
        async with media.speech("robot", rate=16_000) as speech:
            await speech.push(np.sin(np.arange(8_000) / 8) * 0.4)
            assert (await speech.finish()).seconds == 0.5
        assert np.abs(app.media(stream_id).sound()).max() > 0.2


async def test_it_tells_of_persons_that_its_camera_sees_while_that_is_asked_for() -> None:
    async with house(BEFORE_CLERK) as home, Client(home.url) as client:
        detection, localization = await client.find(PersonDetection), await client.find(PersonLocalization)
        async with asyncio.timeout(60):
            async with detection.person_detected() as detected, localization.person_localized() as localized:
                found = await anext(aiter(detected))
                while found.number == 0:
                    found = await anext(aiter(detected))
                assert found.number == 1
                x, y, th = map(float, (await anext(aiter(localized))).position_data[0].split(","))
                clerk = next(each for each in APARTMENT.persons if each.name == "clerk").place
                assert math.dist((x, y), (clerk.x, clerk.y)) < 0.7, "on the robot's map; a third of two metres is far"
                assert abs(math.remainder(th - clerk.th, math.tau)) < 0.5
            await closed(home.robot.camera)
