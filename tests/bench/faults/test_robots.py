"""Robots in processes of their own are told to stop by their own stop, whatever ends their motion."""

import random

import pytest
from openrois_bench.faults.robots import FAULTS, ROBOTS, measured, stage

from tests.support.kachaka_api import needs_kachaka

pytestmark = pytest.mark.timeout(120)


@pytest.mark.long
@needs_kachaka
async def test_a_kachaka_is_told_to_stop_when_its_gateway_hangs() -> None:
    async with stage("kachaka") as robot:
        found = await measured(robot, ROBOTS["kachaka"][0], "gateway frozen", 1, random.Random(1))
    assert found.times.count == 1
    assert found.longest > 0


@pytest.mark.long
@needs_kachaka
@pytest.mark.parametrize("name", ROBOTS)
async def test_every_fault_ends_every_motion(name: str) -> None:
    async with stage(name) as robot:
        for motion in ROBOTS[name]:
            for fault in FAULTS:
                assert (await measured(robot, motion, fault, 1, random.Random(1))).longest > 0
