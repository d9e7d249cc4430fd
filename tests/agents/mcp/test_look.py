"""What an agent sees: a picture of a body's camera over real WebRTC, new, and of a bounded size."""

import base64
import io
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import av
import numpy as np
import pytest
from mcp.client.client import Client as Host
from mcp_types import ImageContent
from openrois_agents.mcp.only_caller import OnlyCaller
from openrois_agents.mcp.server import build_server
from openrois_agents.tools import picture
from openrois_agents.tools.picture import MAX_BYTES
from openrois_agents.tools.settings import ToolSettings
from openrois_agents.tools.untrusted import PICTURE_WARNING
from openrois_streaming.source import stamp

from openrois.client import Client
from openrois.gateway.settings import GatewaySettings
from tests.support.mcp_hosts import text_of
from tests.support.media_body import CAMERA, Body, body

pytestmark = pytest.mark.media

OLDEST = 1.5
"""Seconds: a picture is a second old when it is taken, and this machine may be busy until it is looked at."""


@asynccontextmanager
async def seeing() -> AsyncIterator[tuple[Host, Body]]:
    async with body(GatewaySettings(port=0)) as robot:
        caller = OnlyCaller(lambda: Client(robot.url), ToolSettings())
        async with Host(build_server(lambda: caller.handlers)) as host:
            yield host, robot
        await caller.leave()


async def test_a_picture_is_new_and_as_small_as_asked_for() -> None:
    async with seeing() as (host, _):
        seen = await host.call_tool("look", {"width": 200})
        assert text_of(seen).startswith(f"{CAMERA}, 200x112, 0.")
        assert PICTURE_WARNING in text_of(seen)
        assert seen.content[1].type == "image"
        whole = await host.call_tool("look", {})
        taken = time.time()
        image = whole.content[1]
        assert isinstance(image, ImageContent)
        assert whole.structured_content["age_seconds"] <= OLDEST
        file = base64.b64decode(image.data)
        assert len(file) <= MAX_BYTES
        with av.open(io.BytesIO(file), "r", format="mjpeg") as opened:
            (shown,) = opened.decode(video=0)
        assert (shown.width, shown.height) == (320, 180)
        read = stamp.read(np.asarray(shown.to_ndarray(format="gray"), np.uint8))
        assert read is not None
        assert 0 <= read.age(taken) < OLDEST


async def test_an_old_picture_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    async with seeing() as (host, robot):
        monkeypatch.setattr(picture, "_TIMEOUT", 6.0)
        # A report that a busy machine hands over late makes pictures younger by as much.
        robot.picture.delay = 2.0
        seen = await host.call_tool("look", {})
        assert seen.is_error
        assert text_of(seen) == (
            f"ComponentFailed: {CAMERA} gave no picture within 6 s: its pictures are older than 1 s"
        )


async def test_a_body_without_a_camera_says_so() -> None:
    async with seeing() as (host, _):
        refused = await host.call_tool("look", {"camera": "robot/nothing"})
        assert text_of(refused) == f"BadParameter: robot has no camera 'robot/nothing': it has {CAMERA}"


def test_a_picture_that_says_much_is_made_smaller() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (720, 1280, 3), np.uint8)
    file, width, height = picture._encoded(noise, 768)
    assert (width, height) == (768, 432)
    assert len(file) <= MAX_BYTES
    assert file.startswith(b"\xff\xd8")
