"""The avatar and the robot of the demo, as two applications in C# have them.

The counterpart of `tests/web_sdk/test_two_bodies.py`.
"""

import asyncio
import re
from pathlib import Path
from typing import Final

import pytest

from tests.support.demo import running_demo
from tests.support.mono import Mono
from tests.support.visitors import running, served

pytestmark = [pytest.mark.robots, pytest.mark.long, pytest.mark.engine, pytest.mark.timeout(600)]

PATIENCE: Final = 240.0
"""Seconds for all visitors: speech and ways of both bodies take thirty on an idle machine."""


async def test_two_applications_share_the_bodies_of_the_demo_of_which_one_dies(
    panda3d: None, mono: Mono, two_bodies: Path, tmp_path: Path
) -> None:
    ours, theirs = [f"guest {number}" for number in range(3)], [f"visitor {number}" for number in range(3)]
    program = mono.command(two_bodies)
    with running_demo(tmp_path, "panda3d", ("--with", "robot")) as demo:
        async with (
            asyncio.timeout(PATIENCE),
            running(*program, demo.url, *ours) as first,
            running(*program, demo.url, *theirs) as second,
        ):
            await first.says("took care|was lost")
            demo.program("robot").kill()
    for application, visitors in ((first, ours), (second, theirs)):
        assert re.fullmatch(r"(avatar greeted, robot|robot greeted, avatar) guided", application.lines[0])
        assert set(served(application.lines, visitors)) <= {"avatar", "robot"}
