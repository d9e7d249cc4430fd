"""What an application sees of an adapter that stands still for a moment."""

import asyncio
import signal

import pytest

from tests.support.black_box import H264, VIDEO, application
from tests.support.demo import Demo

pytestmark = pytest.mark.media


async def test_adapter_standstill_loses_no_viewer(demo: Demo) -> None:
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
