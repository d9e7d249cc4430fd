"""The simulator as a program of its own."""

import asyncio
import sys
import time

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.kachaka.api.calls import KachakaApi, get_request

from openrois.adapter import ComponentFailed
from tests.support.kachaka import simulator_process
from tests.support.robots import ended


async def test_it_says_where_it_is_and_has_its_options() -> None:
    async with simulator_process("--battery", "33", "--pace", "2") as home, KachakaApi(home.address) as api:
        response = await api.call("GetBatteryInfo", deadline=10)
        assert round(response.remaining_percentage) == 33
        waiting = asyncio.ensure_future(
            api.call("GetError", get_request(response.metadata.cursor + 10**9), deadline=20)
        )
        await api.call("GetRobotPose", deadline=10)
        home.process.terminate()
        assert await home.process.wait() == 0
        assert await home.said() == "", "it ends without a word"
        assert isinstance(await ended(waiting), ComponentFailed | None)


async def test_it_tells_when_it_is_told_to_stop() -> None:
    async with simulator_process("--tell-stops") as home, KachakaApi(home.address) as api:
        began = time.monotonic()
        await api.call("SetEmergencyStop", pb2.EmptyRequest(), deadline=10)
        assert home.process.stdout is not None
        async with asyncio.timeout(10):
            word, _, at = (await home.process.stdout.readline()).decode().partition(" ")
        assert word == "stopped"
        assert began <= float(at) <= time.monotonic()


async def test_a_port_that_is_taken_ends_it() -> None:
    async with simulator_process() as home:
        second = await asyncio.create_subprocess_exec(
            sys.executable,
            *("-m", "openrois_robots.kachaka.simulator", "--port", str(home.address.port)),
            stderr=asyncio.subprocess.PIPE,
        )
        _, said = await second.communicate()
        assert second.returncode == 1
        assert f"nothing can listen at 127.0.0.1:{home.address.port}: ".encode() in said
