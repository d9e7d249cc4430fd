"""Components that are connected to what they depend on, for as long as their adapter lives."""

import asyncio

import pytest

from openrois.adapter import Component
from openrois.adapter.lifecycle import connected
from openrois.adapter.running import hosted
from openrois.errors import BadParameter
from tests.support.components import Lamp

pytestmark = pytest.mark.extra(name="base")


class Robot(Component):
    """Has a body that is there at the attempt that the test says."""

    def __init__(self, name: str, there_at: int = 1) -> None:
        super().__init__(name)
        self.there_at = there_at
        self.log: list[str] = []
        self.up = asyncio.Event()

    async def connect(self) -> None:
        self.log.append("connect")
        if self.log.count("connect") < self.there_at:
            raise OSError("no route to the body")
        self.up.set()

    async def disconnect(self) -> None:
        self.log.append("disconnect")


class Time:
    """Delays are noted and pass at once."""

    def __init__(self) -> None:
        self.delays: list[float] = []

    async def sleep(self, seconds: float) -> None:
        self.delays.append(seconds)


async def test_all_are_connected_and_let_go_side_by_side() -> None:
    robots = [Robot("a"), Robot("b")]
    async with connected(robots):
        assert [robot.status.value for robot in robots] == ["UNINITIALIZED"] * 2
        async with asyncio.timeout(60):
            await asyncio.gather(*(robot.up.wait() for robot in robots))
        assert [robot.status.value for robot in robots] == ["READY"] * 2
    assert [robot.log for robot in robots] == [["connect", "disconnect"]] * 2


async def test_what_fails_is_tried_again_ever_more_seldom(caplog: pytest.LogCaptureFixture) -> None:
    time, robot, healthy = Time(), Robot("a", there_at=4), Robot("b")
    async with connected([robot, healthy], sleep=time.sleep), asyncio.timeout(60):
        await robot.up.wait()
        await healthy.up.wait()
    assert time.delays == [1, 1.5, 2.25]
    assert robot.log == ["connect"] * 4 + ["disconnect"]
    assert caplog.text.count("a is not connected: a: connect failed: no route to the body") == 3
    assert "Traceback" not in caplog.text


async def test_a_bug_in_connect_is_told_with_its_place(caplog: pytest.LogCaptureFixture) -> None:
    class Clumsy(Robot):
        async def connect(self) -> None:
            raise KeyError("port")

    assert not await Clumsy("a").bring_up()
    assert "in connect" in caplog.text


async def test_what_was_never_connected_is_not_let_go() -> None:
    asleep = asyncio.Event()

    async def sleep(_seconds: float) -> None:
        asleep.set()
        await asyncio.Event().wait()

    robot = Robot("a", there_at=2)
    async with connected([robot], sleep=sleep), asyncio.timeout(60):
        await asleep.wait()
        assert robot.status.value == "ERROR"
    assert robot.log == ["connect"]


async def test_commands_end_before_their_component_is_let_go() -> None:
    class Arm(Robot):
        async def disconnect(self) -> None:
            self.log.append("disconnect")

    class Swinging(Lamp):
        ended_with = ""

        async def start(self) -> None:
            try:
                await super().start()
            finally:
                self.ended_with = arm.status.value

    arm, lamp = Arm("arm"), Swinging()
    async with hosted("robot", arm, lamp) as host:
        async with asyncio.timeout(60):
            await arm.up.wait()
        host.tasks.start(_run(host.engine.invoke("robot/lamp", "start")))
        async with asyncio.timeout(60):
            await lamp.glowing.wait()
    assert lamp.ended_with == "READY"
    assert arm.log == ["connect", "disconnect"]


async def _run(work: object) -> None:
    await work  # type: ignore[misc]


async def test_names_that_are_there_twice_are_a_mistake() -> None:
    with pytest.raises(BadParameter, match="taken"):
        async with hosted("robot", Lamp(), Lamp()):
            pass
