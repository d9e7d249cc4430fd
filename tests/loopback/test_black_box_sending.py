"""What `docs/reference/wire.md` promises to applications that send, seen by one that was written from it alone."""

import asyncio
import json
from collections.abc import AsyncIterator

import pytest

from tests.support.black_box import AUDIO, VIDEO, VP8, Application, Message, application
from tests.support.black_box_media import Camera, Microphone
from tests.support.demo import Demo

pytestmark = pytest.mark.media

OPERATOR = "avatar/operator"


@pytest.fixture
async def app(demo: Demo) -> AsyncIterator[Application]:
    async with application(demo.url) as connected:
        await connected.hello()
        connected.devices = {"audio": Microphone(), "video": Camera()}
        yield connected


async def asked(app: Application, query: str) -> dict[str, str]:
    condition = f"component_ref = '{OPERATOR}'"
    answer = await app.ask("rois.query.query", query_type=query, condition=condition)
    assert answer["return_code"] == "OK", answer
    return {result["name"]: result["value"] for result in answer["results"]}


class Levels:
    """The events about the microphone, one after another."""

    def __init__(self, app: Application) -> None:
        self._app = app
        self._read = 0

    async def until(self, low: float, high: float) -> None:
        """Read on to a root mean square between `low` and `high`."""
        rms = 1.0
        while not low <= rms <= high:
            await self._app.news.until(lambda: len(self._app.told("rois.event.notify_event")) > self._read)
            notice = self._app.told("rois.event.notify_event")[self._read]
            self._read += 1
            detail = await self._app.ask("rois.event.get_event_detail", event_id=notice["event_id"])
            [rms] = [float(each["value"]) for each in detail["results"] if each["name"] == "rms"]


async def test_microphone_and_camera_reach_the_adapter(app: Application) -> None:
    offered = await app.ask("rois.command.get_parameter", component_ref=AUDIO)
    [available] = [each["value"] for each in offered["parameters"] if each["name"] == "available_transports"]
    assert json.loads(available) == {"direction": ["recvonly", "sendonly", "sendrecv"]}
    assert await asked(app, "microphone") == {"connected": "false", "rms": "-100.0", "peak": "-100.0"}
    subscription: Message = await app.ask(
        "rois.event.subscribe", event_type="microphone_level", condition=f"component_ref = '{OPERATOR}'"
    )
    assert subscription["return_code"] == "OK"
    talk, camera = await app.play(AUDIO, direction="sendrecv"), await app.play(VIDEO, VP8, "sendonly")
    levels = Levels(app)
    await levels.until(-13.5, -10.5)
    assert (await asked(app, "microphone"))["connected"] == "true"
    seen = await asked(app, "camera")
    assert (seen["width"], seen["height"]) == ("320", "180")
    assert float(seen["brightness"]) > 0.9

    assert await app.act("suspend", talk) == "OK"
    await levels.until(-100, -100)
    assert await app.act("resume", talk) == "OK"
    await levels.until(-13.5, -10.5)

    parameter = {"name": "transport_parameters", "data_type_ref": "String", "value": '{"direction": "sendonly"}'}
    more = await app.ask("rois.stream.connect_stream", component_ref=AUDIO, parameters=[parameter])
    assert more["return_code"] == "OUT_OF_RESOURCES"
    for stream_id in (talk, camera):
        assert await app.act("disconnect", stream_id) == "OK"
        await app.until_status(stream_id, "NOT_CONNECTED")
    assert (await asked(app, "microphone"))["connected"] == "false"


async def test_a_device_that_is_refused_ends_its_stream_alone(app: Application) -> None:
    app.devices = {}
    picture = await app.play(VIDEO, VP8)
    camera = await app.connect_stream(VIDEO, VP8, "sendonly")
    await app.until_status(camera, "NOT_CONNECTED")
    assert await app.pictures(picture, 3)
    assert await app.status(picture) == "STREAMING_RUNNING"
    assert app.told("signaling.bye") == []
    app.devices = {"video": Camera()}
    again = await app.play(VIDEO, VP8, "sendonly")
    await asyncio.gather(app.act("disconnect", again), app.act("disconnect", picture))
