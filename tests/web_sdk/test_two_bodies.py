"""The avatar and the robot of the demo with two applications that compete for them, one in Python and one in Node.

A body is killed midway and replaced, and a viewer behind a bad path goes on seeing both.
"""

import asyncio
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest
from openrois_streaming.testing import ImpairedPath, Impairments

from openrois.client import Client
from tests.support.demo import Demo, running_demo
from tests.support.invariants import Book
from tests.support.spectator import Spectator
from tests.support.visitors import running, served

pytestmark = [pytest.mark.media, pytest.mark.engine, pytest.mark.long, pytest.mark.timeout(300)]

ROOT: Final = Path(__file__).parents[2]
EXAMPLES: Final = ROOT / "docs/examples"
WEB_DEMO: Final = ROOT / "web_demo"
PATIENCE: Final = 240.0
"""Seconds for all visitors: speech and ways of both bodies take thirty on an idle machine."""


@pytest.fixture(scope="module")
def demo(panda3d: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    with running_demo(tmp_path_factory.mktemp("bodies"), "panda3d", ("--with", "robot")) as demo:
        yield demo


@pytest.fixture
def node_program(package: Path, tmp_path: Path) -> Path:
    """The example for Node, in a folder with the package."""
    (tmp_path / "node_modules").mkdir()
    (tmp_path / "node_modules/openrois").symlink_to(package)
    (tmp_path / "node_modules/ws").symlink_to(WEB_DEMO / "node_modules/ws")
    program = tmp_path / "two_bodies.mjs"
    program.write_text((EXAMPLES / "two_bodies.mjs").read_text())
    return program


async def test_two_applications_share_two_bodies_of_which_one_dies(demo: Demo, node: Path, node_program: Path) -> None:
    ours, theirs = [f"guest {number}" for number in range(3)], [f"visitor {number}" for number in range(3)]
    bad = Impairments(loss=0.02, delay=0.05, jitter=0.02)
    async with (
        asyncio.timeout(PATIENCE),
        ImpairedPath(bad, bad) as path,
        ImpairedPath(bad, bad) as other_path,
        ImpairedPath(bad, bad) as path_back,
        Book().application(Spectator, demo.url, extended=True) as viewer,
        running(sys.executable, str(EXAMPLES / "two_bodies.py"), demo.url, *ours) as first,
        running(str(node), str(node_program), demo.url, *theirs) as second,
    ):
        viewer.path = path
        streams = [await viewer.play("avatar/video_streaming")]
        viewer.path = other_path
        streams.append(await viewer.play("robot/video_streaming"))
        await first.says("took care|was lost")
        demo.program("robot").kill()
        await viewer.is_now(streams[1], "NOT_CONNECTED")
        await viewer.sees(streams[0], 10)
        async with Client(demo.url) as client:
            while "robot" not in {each.engine_id for each in await client.bodies()}:
                pass
        # The restarted robot is another one to its viewers.
        viewer.path = path_back
        await viewer.play("robot/video_streaming")
    for program, visitors in ((first, ours), (second, theirs)):
        assert re.fullmatch(r"avatar greeted, robot guided", program.lines[0]), program.lines
        assert set(served(program.lines, visitors)) <= {"avatar", "robot"}
    assert {*served(first.lines, ours), *served(second.lines, theirs)} == {"avatar", "robot"}
