"""The adapter of a Reachy Mini as a process behind a real gateway: killed, left by its application, examined."""

import asyncio
import signal
import time
from contextlib import suppress

import pytest
from openrois_body.components.reaction import reaction_ref
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.stage import Needs
from openrois_conformance.suite import Outcome, run_checks, visit

from openrois.client import Client
from openrois.client.components import Reaction, SystemInformation
from openrois.errors import RoISError
from tests.robots.reachy.behaviour_suite import react
from tests.support.reachy import DaemonPlace, Watcher
from tests.support.reachy_home import Home, home
from tests.support.robots import ended, until

__all__ = ["ProcessSuite"]

PATIENCE = 20.0
"""Seconds that an answer may take on a busy machine."""
AFTERWARDS = 1.0
"""Seconds in which the robot would have looked to the left."""


async def awake(client: Client) -> None:
    """Have the robot linked, awake, and in its neutral posture."""
    information = await client.find(SystemInformation)
    async with asyncio.timeout(PATIENCE):
        while (await information.query("health"))["health"]:
            with suppress(RoISError):
                await react(client, "wake_up")
    await react(client, "wake_up")


class ProcessSuite:
    """A subclass has the fixture `daemon`."""

    async def test_nothing_moves_on_when_the_adapter_is_killed(self, daemon: DaemonPlace) -> None:
        async with (
            Watcher.watching(daemon.address) as watcher,
            home(daemon.address) as house,
            Client(house.url) as client,
        ):
            await awake(client)
            looking = asyncio.create_task(react(client, "look_around"))
            await until(lambda: watcher.posture.yaw > 0.3)
            begun = time.monotonic()
            house.adapter.kill()
            await house.adapter.wait()
            assert await ended(looking) is not None
            await until(lambda: time.monotonic() > begun + AFTERWARDS)
        stood = watcher.stood_at(begun) - begun
        print(f"SIGKILL: the robot stands {1000 * stood:.0f} ms later, its shortest reaction takes 760 ms")
        assert watcher.posture.yaw < 0.5

    @pytest.mark.long
    @pytest.mark.parametrize("ends_by", ["releasing it", "leaving"])
    async def test_an_application_that_lets_go_leaves_a_robot_that_stands(
        self, daemon: DaemonPlace, ends_by: str
    ) -> None:
        async with (
            Watcher.watching(daemon.address) as watcher,
            home(daemon.address) as house,
            Client(house.url) as client,
        ):
            await awake(client)
            reaction = await client.find(Reaction)
            await reaction.bind()
            await reaction.set(reaction_ref=reaction_ref("look_around"))
            looking = asyncio.create_task(client.run(reaction.start()))
            await until(lambda: watcher.posture.yaw > 0.3)
            begun = time.monotonic()
            if ends_by == "leaving":
                await client.close()
            else:
                await reaction.release()
            await ended(looking)
            await until(lambda: time.monotonic() > begun + AFTERWARDS)
        stood = watcher.stood_at(begun) - begun
        print(f"{ends_by}: the robot stands {1000 * stood:.0f} ms later")
        assert watcher.posture.yaw < 0.5

    @pytest.mark.timeout(300)
    async def test_it_conforms_and_ends_with_a_signal(self, daemon: DaemonPlace) -> None:
        async with home(daemon.address) as house:
            async with Client(house.url) as client:
                await awake(client)
                (body,) = await client.bodies()
            assert len(body.components) == 7
            for component in body.components:
                assert await _conforms(house, component.component_ref) == {}, component.component_ref
            house.adapter.send_signal(signal.SIGTERM)
            assert await house.adapter.wait() == 0


async def _conforms(house: Home, component_ref: str) -> dict[str, str]:
    """Return what is wrong with a component, by the check that says so."""
    checks = [check for check in ALL_CHECKS if Needs.COMPONENT in check.needs]
    async with visit(house.url, PATIENCE, adapter=False, component=component_ref) as place:
        verdicts = await run_checks(place, checks)
    return {each.check.id: f"{each.expected} / {each.came}" for each in verdicts if each.outcome is Outcome.FAILED}
