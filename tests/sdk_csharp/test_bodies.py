"""Bodies, as applications in C# reserve them, share them and lose them."""

import asyncio
import re
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any, cast

import pytest

from openrois.catalog.actuation import NAVIGATION, SPEECH_SYNTHESIS
from openrois.catalog.component_type import ComponentType
from openrois.engine.registry import LocalRegistry
from tests.sdk_csharp.conftest import Start
from tests.sdk_csharp.test_operations import attached
from tests.support.deployment import gateway, until
from tests.support.fleet import Part, Robot, everything, fleet
from tests.support.mono import Mono
from tests.support.visitors import running, served

pytestmark = pytest.mark.timeout(120)


async def receive_visitors(mono: Mono, program: Path) -> None:
    """Let five visitors be received, as many at a time as there are bodies."""
    async with gateway() as here, attached(here, everything("avatar"), everything("robot")):
        visitors = [f"visitor {number}" for number in range(1, 6)]
        printed = await asyncio.to_thread(mono.run, program, here.url, *visitors)
    first, *others = printed.splitlines()
    assert first == "avatar greeted, robot guided"
    assert set(served(others, visitors)) == {"avatar", "robot"}


async def test_two_bodies_receive_visitors(mono: Mono, two_bodies: Path) -> None:
    await receive_visitors(mono, two_bodies)


class Patient(Part):
    """A robot's Navigation that never arrives with a visitor: it is midway until the robot dies."""

    def __init__(self, kind: ComponentType) -> None:
        super().__init__(kind)
        self.speech = Part(SPEECH_SYNTHESIS)
        self.is_midway = asyncio.Event()

    async def _start(self) -> None:
        if str(self.speech.parameters["speech_text"]).startswith("Good day"):
            self.is_midway.set()
            await asyncio.Event().wait()
        await super()._start()


async def test_two_applications_compete_for_bodies_of_which_one_dies_midway(mono: Mono, two_bodies: Path) -> None:
    slow = Patient(NAVIGATION)
    parts = {"Navigation": slow, "SpeechSynthesis": slow.speech}
    dies = Robot(LocalRegistry("robot", cast(Any, parts.values())), parts)
    ours, theirs = [f"guest {number}" for number in range(3)], [f"visitor {number}" for number in range(3)]
    program = mono.command(two_bodies)
    async with (
        asyncio.timeout(60),
        gateway() as here,
        attached(here, everything("avatar")),
        AsyncExitStack() as stack,
        AsyncExitStack() as programs,
    ):
        async with attached(here, dies):
            first = await programs.enter_async_context(running(*program, here.url, *ours))
            second = await programs.enter_async_context(running(*program, here.url, *theirs))
            await slow.is_midway.wait()
        # Another one takes its place; an application that has not greeted yet waits for that.
        await stack.enter_async_context(attached(here, everything("robot")))
    lost = [line for program in (first, second) for line in program.lines if "robot was lost" in line]
    assert len(lost) == 1
    for application, visitors in ((first, ours), (second, theirs)):
        assert re.fullmatch(r"(avatar greeted, robot|robot greeted, avatar) guided", application.lines[0])
        assert set(served(application.lines, visitors)) <= {"avatar", "robot"}


async def test_of_rivals_one_gets_a_body_and_the_other_nothing_of_it(start: Start) -> None:
    async with gateway() as running, attached(running, everything()), start("rivals", running.url) as app:
        assert await app.says("first") == "robot"
        assert await app.says("free") == [["robot", False]]
        assert await app.says("refs") == ["robot/reaction"]
        refused = await app.says("refused")
        assert refused.startswith(
            "no body with Navigation and Reaction is free: robot: rois.command.bind(robot/reaction): "
        )
        assert await app.says("rest") == "robot/navigation"
        assert await app.says("partly") == [True, True]
        assert await app.says("without") == "KeyNotFoundException"
        assert await app.says("waited") == "robot"
        assert await app.says("again") == "robot"
        assert await app.says("over") == "ConnectionLostException"
        await app.ends()


async def test_a_body_that_is_lost_is_given_back(start: Start) -> None:
    async with gateway() as running:
        url = running.url.replace("http", "ws") + "adapter"
        async with fleet(url, everything("robot")):
            await until(running.engine, lambda ids: "robot" in ids)
            app = start("owner", running.url)
            owner = await app.__aenter__()
            assert await owner.says("has") == "robot"
        assert await owner.says("lost") == ["robot", "UnsupportedException", True]
        assert await owner.says("part") == "UnsupportedException"
        async with attached(running, everything("avatar")):
            assert await owner.says("another") == "avatar"
            await owner.go_on()
            await owner.ends()
            await app.__aexit__(None, None, None)


async def test_callbacks_come_on_the_thread_that_pumps(start: Start) -> None:
    async with gateway() as running, attached(running, everything()), start("main_thread", running.url) as app:
        # All notices of the connection wait in one place, 400 events in another.
        assert await app.says("before") == [0, 2]
        assert await app.says("after") == [256, "place 144", "place 199", 144]
        assert await app.says("threads") is True
        assert await app.says("failures") == ["a mistake of the application"] * 2
        assert await app.says("disposed") == 256
        await app.ends()


async def test_a_client_needs_no_threads(start: Start) -> None:
    async with gateway() as running, attached(running, everything()), start("one_thread", running.url) as app:
        assert await app.says("reached") == "lobby"
        assert await app.says("elsewhere") == []
        await app.ends()
