"""The simulator as a program of its own."""

import asyncio
import sys

from openrois_robots.kachaka.api.calls import KachakaApi

from tests.support.kachaka import simulator_process


async def test_it_says_where_it_is_and_has_its_options() -> None:
    async with simulator_process("--battery", "33", "--pace", "2") as home, KachakaApi(home.address) as api:
        response = await api.call("GetBatteryInfo", deadline=10)
        assert round(response.remaining_percentage) == 33
        home.process.terminate()
        assert await home.process.wait() == 0


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
