"""What an application sees when a part of the system dies under it."""

import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest

from tests.support.black_box import AUDIO, H264, VIDEO, Application, application
from tests.support.demo import Demo, running_demo
from tests.support.house import house

pytestmark = [pytest.mark.media, pytest.mark.long]


@pytest.fixture(scope="module")
def fragile(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo of which parts may be killed."""
    with running_demo(tmp_path_factory.mktemp("fragile")) as demo:
        yield demo
        assert "Traceback" not in demo.log(), demo.log()


async def test_a_killed_adapter_is_announced_and_its_successor_can_be_played(fragile: Demo) -> None:
    async with application(fragile.url) as app:
        await app.hello()
        video, audio = await app.play(VIDEO, H264), await app.play(AUDIO)
        dead = app.peer_of(video)

        fragile.program("avatar").kill()
        for stream_id in (video, audio):
            await app.until_status(stream_id, "NOT_CONNECTED", within=3)
        await app.news.until(lambda: changes(app), within=3)
        assert await app.act("suspend", video) == "UNSUPPORTED"
        assert (await app.ask("signaling.restart", peer_id=dead.offers[0]["peer_id"]))["return_code"] == "UNSUPPORTED"

        await attached(app)
        again = await app.play(VIDEO, H264)
        assert again not in (video, audio)
        assert app.peer_of(again) is not dead
        assert len(await app.pictures(again, 10)) == 10


async def test_media_outlives_a_killed_gateway_and_ends_after_the_grace(fragile: Demo) -> None:
    async with application(fragile.url) as orphan:
        await orphan.hello()
        old = await orphan.play(VIDEO, H264)
        killed = time.monotonic()
        fragile.program("gateway").kill()
        await orphan.news.until(lambda: orphan.ended)

        await gateway_is_back(fragile.url, orphan, old)
        async with application(fragile.url) as app:
            await app.hello()
            await attached(app)
            new = await app.play(VIDEO, H264)
            assert new != old
            assert await app.pictures(new, 10)
            assert await orphan.pictures(old, 10), "a cut of the control connection alone does not darken the picture"

            connection = orphan.peer_of(old).connection
            await orphan.news.until(lambda: orphan.media(old).ended and connection.connectionState == "closed")
            last = orphan.media(old).pictures[-1]
            assert 9 < last.at - killed < 12, "no client can command it any more, so it ends after 10 s"
            assert await app.pictures(new, 10)
            assert app.statuses(new) == ["NOT_RUNNING", "RUNNING"]


async def test_a_cut_between_adapter_and_gateway_costs_streams_but_not_the_application() -> None:
    async with house() as home:
        app = await home.guest()
        old = await app.play(VIDEO, H264)
        await home.disconnect()
        await app.until_status(old, "NOT_CONNECTED")
        assert await app.act("suspend", old) == "UNSUPPORTED"
        await home.connect()
        await attached(app)

        new = await app.play(VIDEO, H264)
        assert new != old
        assert app.peer_of(new) is not app.peer_of(old)
        assert await app.pictures(old, 5), "until the grace is over nothing is taken from anybody"
        assert home.figures("video/H264").viewers == 2

        home.grace.set()
        await app.news.until(lambda: app.media(old).ended)
        assert await app.pictures(new, 10)
        assert app.statuses(new) == ["NOT_RUNNING", "RUNNING"]
        assert home.figures("video/H264").viewers == 1


async def attached(app: Application) -> None:
    """Wait until an avatar is there."""
    while True:
        known = changes(app)
        if VIDEO in (await app.ask("rois.system.get_profile"))["component_profiles"]:
            return
        await app.news.until(more_than(known, app))


def changes(app: Application) -> int:
    return len(app.told("rois.system.profile_changed"))


def more_than(known: int, app: Application) -> Callable[[], bool]:
    return lambda: changes(app) > known


async def gateway_is_back(url: str, orphan: Application, stream_id: str) -> None:
    """Wait until the gateway listens again; tried at each picture that still comes."""
    while True:
        await orphan.pictures(stream_id, 1)
        with suppress(OSError):
            async with application(url):
                return
