"""What an application sees of an engine and an adapter that hang or die, and that they come back by themselves."""

import asyncio
import signal
import time
from pathlib import Path

import psutil
import pytest

from tests.support.black_box import H264, VIDEO, Application, application
from tests.support.demo import Demo, running_demo

pytestmark = [pytest.mark.media, pytest.mark.engine]

ERROR = "rois.system.notify_error"


async def test_an_engine_that_hangs_or_dies_is_announced_and_comes_back(tmp_path: Path) -> None:
    with running_demo(tmp_path, "puppet") as demo:
        async with application(demo.url) as app:
            await app.hello()
            stream_id = await app.play(VIDEO, H264)
            assert await app.pictures(stream_id, 5)
            for harm, kind, patience in (
                (signal.SIGSTOP, "COMPONENT_NOT_RESPONDING", 5),
                (signal.SIGKILL, "COMPONENT_INTERNAL_ERROR", 0),
            ):
                known = len(app.told(ERROR))
                harmed = time.monotonic()
                engine(demo).send_signal(harm)
                await app.until_status(stream_id, "NOT_RUNNING", within=patience + 10)
                await app.news.until(lambda known=known: len(app.told(ERROR)) > known, within=patience + 10)  # type: ignore[misc]
                assert app.told(ERROR)[-1]["error_type"] == kind
                assert time.monotonic() - harmed > patience
                await app.until_status(stream_id, "RUNNING", within=20)
                assert await app.pictures(stream_id, 5)
            assert app.statuses(stream_id) == ["NOT_RUNNING", "RUNNING"] * 3
            # The adapter looks several times a second: what is there again is READY a few pictures later.
            while await status_of(app) != "READY":
                await app.pictures(stream_id, 1)


async def test_an_adapter_that_stands_still_for_a_moment_loses_nobody(demo: Demo) -> None:
    async with application(demo.url) as app:
        await app.hello()
        stream_id = await app.play(VIDEO, H264)
        adapter = demo.program("avatar")
        adapter.send_signal(signal.SIGSTOP)
        try:
            await asyncio.sleep(2)  # the adapter's own time: nothing else can be waited for
        finally:
            adapter.send_signal(signal.SIGCONT)
        assert await app.pictures(stream_id, 10)
        await app.until_status(stream_id, "RUNNING")
        assert not app.told("signaling.bye")
        assert "NOT_CONNECTED" not in app.statuses(stream_id)


async def status_of(app: Application) -> str:
    asked = await app.ask("rois.query.query", query_type="component_status", condition=f"component_ref = '{VIDEO}'")
    [status] = asked["results"]
    return str(status["value"])


def engine(demo: Demo) -> psutil.Process:
    """The process that renders."""
    return next(each for each in demo.tree() if each.cmdline()[-1:] == ["openrois_avatar.engines.puppet"])
