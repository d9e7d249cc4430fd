"""What was measured on the vendor's daemon, and is why the adapter does as it does."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import aiohttp
import pytest
from openrois_robots.reachy.postures.posture import NEUTRAL, Posture, turned_away

from tests.support.reachy import DaemonPlace, Watcher
from tests.support.robots import until

__all__ = ["DaemonSuite"]

LEFT, RIGHT = Posture(yaw=0.8), Posture(yaw=-0.8)


class DaemonSuite:
    """Facts. A subclass has the fixture `daemon`."""

    @pytest.fixture
    async def watcher(self, daemon: DaemonPlace) -> AsyncIterator[Watcher]:
        async with Watcher.watching(daemon.address) as watcher:
            if turned_away(watcher.posture, NEUTRAL) > 0.02:
                await watcher.begin_task(NEUTRAL, 0.5)
                await until(lambda: watcher.ended)
                watcher.ended.clear()
            yield watcher

    async def test_a_task_is_carried_out_and_its_end_is_told(self, watcher: Watcher) -> None:
        task = await watcher.begin_task(LEFT, 0.5)
        await until(lambda: watcher.ended)
        assert watcher.ended[0][:2] == (task, None)
        await until(lambda: turned_away(watcher.posture, LEFT) < 0.02)

    async def test_a_second_task_is_not_refused_and_both_run(self, watcher: Watcher) -> None:
        # Not far from each other: after a large jump the vendor's mock-up tells postures that are wrong.
        first = await watcher.begin_task(Posture(yaw=0.2), 1.2)
        await asyncio.sleep(0.5)
        second = await watcher.begin_task(Posture(yaw=-0.2), 1.2)
        await until(lambda: len(watcher.ended) == 2)
        assert [each[:2] for each in watcher.ended] == [(first, None), (second, None)]
        assert watcher.ended[1][2] - watcher.ended[0][2] < 1.0, "one after the other they would take 1.2 s more"

    async def test_a_target_during_a_task_is_ignored_without_a_word(self, watcher: Watcher) -> None:
        await watcher.begin_task(LEFT, 0.6)
        await asyncio.sleep(0.1)
        await watcher.send(type="set_full_target", head=RIGHT.matrix, antennas=[1.0, 1.0], body_yaw=0.0)
        await until(lambda: watcher.ended)
        await until(lambda: turned_away(watcher.posture, LEFT) < 0.02)

    async def test_a_stopped_task_has_finished_without_an_error(self, watcher: Watcher) -> None:
        task = await watcher.begin_task(LEFT, 3.0)
        await until(lambda: watcher.posture.yaw > 0.1)
        await watcher.send(type="stop_move")
        await until(lambda: watcher.ended)
        assert watcher.ended[0][:2] == (task, None)
        await until(lambda: not watcher.moves())
        assert watcher.posture.yaw < 0.7

    async def test_a_task_goes_on_when_its_client_is_gone(self, watcher: Watcher, daemon: DaemonPlace) -> None:
        async with Watcher.watching(daemon.address) as other:
            await other.begin_task(LEFT, 1.5)
            await until(lambda: watcher.posture.yaw > 0.02)
            await other.close()
        await until(lambda: turned_away(watcher.posture, LEFT) < 0.02)

    async def test_sounds_are_played_with_success_although_nothing_is_heard(
        self, watcher: Watcher, daemon: DaemonPlace
    ) -> None:
        async with aiohttp.ClientSession(daemon.address.url("http")) as session:
            async with session.get("/api/media/status") as answer:
                assert await answer.json() == {"available": False, "released": False, "no_media": True}
            async with session.post("/api/media/play_sound", json={"file": "none.wav"}) as answer:
                assert (answer.status, await answer.json()) == (200, {"status": "ok"})

    async def test_directions_of_sounds_are_null_without_microphones(
        self, watcher: Watcher, daemon: DaemonPlace
    ) -> None:
        async with (
            aiohttp.ClientSession(daemon.address.url("http")) as session,
            session.get("/api/state/doa") as answer,
        ):
            assert (answer.status, await answer.json()) == (200, None)

    async def test_emotions_are_downloads_and_fail_offline(self, watcher: Watcher, daemon: DaemonPlace) -> None:
        path = "/api/move/play/recorded-move-dataset/pollen-robotics/reachy-mini-emotions-library/happy1"
        async with aiohttp.ClientSession(daemon.address.url("http")) as session, session.post(path) as answer:
            assert answer.status == 500

    async def test_a_client_of_a_daemon_that_was_stopped_is_told_nothing_more(
        self, watcher: Watcher, daemon: DaemonPlace
    ) -> None:
        async with (
            _restarted_afterwards(daemon),
            aiohttp.ClientSession(daemon.address.url("http")) as session,
        ):
            async with session.post("/api/daemon/stop", params={"goto_sleep": "false"}) as answer:
                assert answer.status == 200
            async with asyncio.timeout(30):
                while True:
                    async with session.get("/api/daemon/status") as answer:
                        if (await answer.json())["state"] == "stopped":
                            break
            told = len(watcher.postures)
            async with session.ws_connect("/ws/sdk") as socket:
                with suppress(TimeoutError):
                    async with asyncio.timeout(0.4):
                        assert "head_pose" not in [json.loads(each.data)["type"] async for each in socket]
            assert len(watcher.postures) <= told + 1


@asynccontextmanager
async def _restarted_afterwards(daemon: DaemonPlace) -> AsyncIterator[None]:
    try:
        yield
    finally:
        await daemon.kill()
        await daemon.start_again()
