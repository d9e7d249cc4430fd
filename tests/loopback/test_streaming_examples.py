"""The camera and the rover of the guide, as a person runs them."""

import asyncio
import os
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import pytest
from aiohttp import web
from numpy.typing import NDArray

from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.black_box import Application, application
from tests.support.deployment import until

pytestmark = pytest.mark.media

ROOT: Final = Path(__file__).parents[2]
EXAMPLES: Final = ROOT / "docs/examples"
PHOTO: Final = np.asarray(cv2.imread(str(ROOT / "tests/support/photos/collins.jpg")), np.uint8)
SIZE: Final = (640, 480)


def enlarged(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture in the size of the camera."""
    return np.asarray(cv2.resize(picture, SIZE), np.uint8)


@asynccontextmanager
async def network_camera() -> AsyncIterator[str]:
    """Serve the photograph thirty times a second, as cameras in networks do; yields the URL."""
    jpeg = cv2.imencode(".jpg", enlarged(PHOTO))[1].tobytes()

    async def film(request: web.Request) -> web.StreamResponse:
        response = web.StreamResponse(headers={"Content-Type": "multipart/x-mixed-replace; boundary=next"})
        await response.prepare(request)
        head = f"--next\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n".encode()
        while True:
            await response.write(head + jpeg + b"\r\n")
            await asyncio.sleep(1 / 30)

    server = web.Application()
    server.router.add_get("/film.mjpg", film)
    runner = web.AppRunner(server, shutdown_timeout=0.1)
    await runner.setup()
    try:
        site = web.TCPSite(runner, "127.0.0.1", 0)
        await site.start()
        yield f"http://127.0.0.1:{runner.addresses[0][1]}/film.mjpg"
    finally:
        await runner.cleanup()


@asynccontextmanager
async def running(gateway: Gateway, example: str, engine_id: str, **environment: str) -> AsyncIterator[Application]:
    """Run an example for as long as the block does, and yield an application."""
    own = {**os.environ, "OPENROIS_GATEWAY": gateway.url, **environment}
    process = await asyncio.create_subprocess_exec(sys.executable, EXAMPLES / example, env=own)
    try:
        await until(gateway.engine, lambda ids: engine_id in ids)
        async with application(gateway.url.replace("http", "ws", 1)) as app:
            await app.hello()
            yield app
    finally:
        process.terminate()
        await process.wait()


async def shows(app: Application, stream: str, expected: NDArray[np.uint8]) -> None:
    """Wait until the pictures of a stream are like `expected` (BGR)."""
    luma = cv2.cvtColor(expected, cv2.COLOR_BGR2YUV_I420)[: expected.shape[0]]

    def alike() -> bool:
        seen = app.media(stream).luma
        return seen is not None and np.abs(cv2.resize(seen, luma.shape[::-1]).astype(int) - luma).mean() < 8

    await app.news.until(alike)


async def bind(app: Application, component_ref: str, **parameters: tuple[str, str]) -> None:
    """Take a component, and set its parameters: of each the type and the value."""
    assert (await app.ask("rois.command.bind", component_ref=component_ref))["return_code"] == "OK"
    values = [{"name": name, "data_type_ref": kind, "value": value} for name, (kind, value) in parameters.items()]
    answer = await app.ask("rois.command.set_parameter", component_ref=component_ref, parameters=values)
    assert answer["return_code"] == "OK", answer


async def test_a_network_camera_is_watched_and_zoomed() -> None:
    async with (
        run_gateway(GatewaySettings(port=0)) as gateway,
        network_camera() as url,
        running(gateway, "camera_adapter.py", "camera_1", CAMERA=url) as app,
    ):
        stream = await app.play("camera_1/camera")
        await shows(app, stream, enlarged(PHOTO))
        await bind(app, "camera_1/lens", zoom=("Double", "2"))
        await shows(app, stream, enlarged(enlarged(PHOTO)[120:360, 160:480]))


async def test_a_rover_drives_and_is_watched() -> None:
    async with (
        run_gateway(GatewaySettings(port=0)) as gateway,
        running(gateway, "rover_adapter.py", "rover_1") as app,
    ):
        stream = await app.play("rover_1/camera")
        await app.frames(stream, 5)
        luma = app.media(stream).luma
        assert luma is not None
        assert luma[120, 151] < 100, "it is red, and stands in the middle"
        await bind(app, "rover_1/move", line=("Integer[]", "[1000, 90]"))
        unit = {"component_ref": "rover_1/move", "command_type": "start", "command_id": "drive", "arguments": []}
        assert await app.ask("rois.command.execute", command_unit_list=[unit]) == {"return_code": "OK"}

        def ends() -> list[str]:
            return [each["status"] for each in app.told("rois.command.completed") if each["command_id"] == "drive"]

        assert await app.news.until(ends) == ["OK"]
        place = "component_ref = 'rover_1/system_info'"
        asked = await app.ask("rois.query.query", query_type="robot_position", condition=place)
        assert "1.000,0.000,1.571" in str(asked)

        def has_gone() -> bool:
            seen = app.media(stream).luma
            return seen is not None and seen[120, 151] > 110 > 100 > seen[120, 211]

        await app.news.until(has_gone)


@pytest.mark.parametrize(("example", "lines"), [("camera_adapter.py", 60), ("rover_adapter.py", 100)])
def test_examples_are_short(example: str, lines: int) -> None:
    assert len((EXAMPLES / example).read_text().splitlines()) <= lines
