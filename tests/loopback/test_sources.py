"""An adapter written with sources alone, without a word of WebRTC: all of them reach an application."""

import asyncio
import itertools
import threading
import time
from collections.abc import AsyncIterator, Iterator
from typing import Final

import numpy as np
import pytest
from openrois_media import AudioSource, AudioUplink, EncodedSource, Media, Stream, VideoSource, serve
from openrois_media.streams import Source
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.source import RawVideo

from openrois.client import Client
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.black_box import Application, application
from tests.support.black_box_media import Microphone
from tests.support.deployment import until
from tests.support.streaming import settle

pytestmark = pytest.mark.media

SIZE: Final = (160, 96)


class Room:
    """What a robot in a room has to stream: two cameras, a microphone, a speaker."""

    def __init__(self) -> None:
        self.looks = 0
        """How often its camera was opened."""
        self.looking = False
        self.ask_key_frame = False
        self.speaker = AudioUplink()
        self.streams: dict[str, Source | Stream] = {
            "front": VideoSource(self._front, size=SIZE, format="rgb24"),
            "back": EncodedSource(
                self._back,
                size=SIZE,
                mime_type="video/VP8",
                request_key_frame=lambda: setattr(self, "ask_key_frame", True),
            ),
            "ear": AudioSource(self._sound, sample_rate=16_000),
            "mouth": Stream(uplink=self.speaker),
        }

    def _front(self) -> Iterator[np.ndarray]:
        """Red pictures with a bright band that moves, as a driver gives them that blocks."""
        self.looks += 1
        self.looking = True
        try:
            for number in itertools.count():
                time.sleep(1 / 30)
                picture = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
                picture[:, :, 0] = 220
                picture[:, number % SIZE[0]] = 255
                yield picture
        finally:
            self.looking = False

    def _back(self) -> Iterator[bytes]:
        """Grey pictures, encoded elsewhere."""
        encoder = VideoEncoder("video/VP8", bitrate=300_000, frame_rate=30)
        for number in itertools.count():
            time.sleep(1 / 30)
            raw = RawVideo(np.full((SIZE[1] * 3 // 2, SIZE[0]), 100, np.uint8), "i420", *SIZE, number, time.monotonic())
            wanted, self.ask_key_frame = self.ask_key_frame or number == 0, False
            yield from (chunk.data for chunk in encoder.encode(raw, key_frame=wanted))

    def _sound(self) -> Iterator[np.ndarray]:
        """A tone of 500 Hz."""
        for number in itertools.count():
            time.sleep(0.02)
            moments = (np.arange(320) + number * 320) / 16_000
            yield (8000 * np.sin(2 * np.pi * 500 * moments)).astype(np.int16)


@pytest.fixture
async def gateway() -> AsyncIterator[Gateway]:
    async with run_gateway(GatewaySettings(port=0)) as running:
        yield running


async def test_all_that_a_robot_shows_sounds_and_hears(gateway: Gateway) -> None:
    room = Room()
    async with serve(engine_id="robot", streams=room.streams, gateway=gateway.url):
        await until(gateway.engine, lambda ids: "robot" in ids)
        async with application(gateway.url.replace("http", "ws", 1)) as app:
            await app.hello()
            assert not room.looks, "its camera is closed while it is not watched"
            front = await app.play("robot/front", ["video/H264"])
            await app.frames(front, 20)
            luma = app.media(front).luma
            assert luma is not None
            assert luma.shape == (SIZE[1], SIZE[0])
            # Red in limited range (ITU-R BT.601), with a brighter band somewhere.
            assert np.median(luma) == pytest.approx(16 + 0.257 * 220, abs=8)
            assert luma.max() > 130
            await _the_other_streams(app, room)
            await app.act("disconnect", front)
            await app.until_status(front, "NOT_CONNECTED")
            await app.news.until(lambda: not room.looking)
            assert room.looks == 1


async def _the_other_streams(app: Application, room: Room) -> None:
    back = await app.play("robot/back", ["video/VP8", "video/H264"])
    await app.frames(back, 20)
    luma = app.media(back).luma
    assert luma is not None
    assert np.median(luma) == pytest.approx(100, abs=4)
    refusal = await app.ask(
        "rois.stream.connect_stream",
        component_ref="robot/back",
        parameters=[{"name": "encoding_parameters", "data_type_ref": "String", "value": '{"codecs": ["video/H264"]}'}],
    )
    assert refusal["return_code"] == "UNSUPPORTED"

    ear = await app.play("robot/ear")
    await app.news.until(lambda: app.media(ear).blocks > 60)
    sound = app.media(ear).sound()[-24_000:]
    loudest = np.argmax(np.abs(np.fft.rfft(sound))) * 48_000 / len(sound)
    assert loudest == pytest.approx(500, abs=4)

    assert (await app.ask("rois.command.bind", component_ref="robot/mouth"))["return_code"] == "OK"
    app.devices["audio"] = Microphone()
    mouth = await app.connect_stream("robot/mouth", direction="sendonly")
    async with room.speaker.subscribe(10) as blocks:
        heard = [await blocks.get() for _ in range(50)]
    assert max(np.abs(block.samples).max() for block in heard) > 1000
    await app.act("disconnect", mouth)


async def test_a_camera_that_fails_is_opened_again_while_a_viewer_waits(gateway: Gateway) -> None:
    repaired = threading.Event()
    openings = itertools.count(1)

    def pictures() -> Iterator[np.ndarray]:
        if next(openings) > 1 and not repaired.is_set():
            raise OSError("the cable is out")
        for _ in range(60 if not repaired.is_set() else 3000):
            time.sleep(1 / 30)
            yield np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
        raise OSError("the cable is out")

    streams = {"camera": VideoSource(pictures, size=SIZE)}
    async with serve(engine_id="robot", streams=streams, gateway=gateway.url):
        await until(gateway.engine, lambda ids: "robot" in ids)
        async with application(gateway.url.replace("http", "ws", 1)) as app:
            await app.hello()
            stream = await app.play("robot/camera")
            await app.until_status(stream, "NOT_RUNNING")

            def faults() -> list[str]:
                return [each["error_id"] for each in app.told("rois.system.notify_error")]

            await app.news.until(faults)
            detail = await app.ask("rois.system.get_error_detail", error_id=faults()[0], condition="")
            assert "the source of camera has failed: the cable is out" in str(detail["results"])
            repaired.set()
            await app.until_status(stream, "RUNNING")
            await app.frames(stream, 10)


async def test_a_reader_of_a_camera_that_fails_says_why_until_it_works_again(gateway: Gateway) -> None:
    works = threading.Event()
    works.set()

    def pictures() -> Iterator[np.ndarray]:
        while works.is_set():
            time.sleep(1 / 30)
            yield np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)
        raise OSError("the cable is out")

    async with serve(engine_id="robot", streams={"camera": VideoSource(pictures, size=SIZE)}, gateway=gateway.url):
        await until(gateway.engine, lambda ids: "robot" in ids)
        async with Client(gateway.url) as client, Media(client) as media, media.frames("robot/camera") as frames:
            async with asyncio.timeout(60):
                await anext(frames)
                assert frames.problem == ""
                works.clear()
                while not frames.problem:
                    await settle()
                assert frames.problem == "the source of camera has failed: the cable is out"
                works.set()
                while frames.problem:
                    await anext(frames)
