import asyncio

import pytest
from openrois_body.body import Body
from openrois_body.messages import Command, Drive, Halt, Input, LinkError, Look
from openrois_body.motion.legs import Legs
from openrois_body.teleoperation.figure_controls import FigureControls
from openrois_body.teleoperation.steering import Velocity

from openrois.errors import Aborted, ComponentFailed
from tests.support.streaming import VirtualClock, settle


class Engine:
    """A game engine that is there or not, walks or not, and takes input or not."""

    def __init__(self, *, walks: bool = True, takes_input: bool = False) -> None:
        self.heard: list[Command] = []
        self.gone = False
        self.legs = Legs(self.send, lambda: walks, lambda: None, VirtualClock())
        self.controls = FigureControls(self.legs, Body(self.send), self.send, lambda: takes_input)

    def send(self, command: Command) -> None:
        if self.gone:
            raise LinkError("the engine is gone")
        self.heard.append(command)


def test_a_figure_is_driven_halted_and_looks() -> None:
    engine = Engine()
    engine.controls.drive(Velocity(1, 2, 3))
    engine.controls.turn_eyes(0.5, -0.5)
    engine.controls.halt("enough")
    engine.controls.pass_on({"seq": 1})
    assert engine.heard == [Drive(1, 2, 3), Look(0.5, -0.5), Halt()]


async def test_a_hand_that_drives_ends_what_moved() -> None:
    engine = Engine()

    async def walk() -> None:
        async with engine.legs.motion("a walk"):
            await asyncio.Event().wait()

    walking = asyncio.ensure_future(walk())
    await settle()
    engine.controls.drive(Velocity(1))
    with pytest.raises(Aborted, match="by hand"):
        await walking


@pytest.mark.parametrize("gone", [False, True])
def test_a_figure_that_does_not_walk_or_is_gone(gone: bool) -> None:
    engine = Engine(walks=gone)
    engine.gone = gone
    with pytest.raises(ComponentFailed):
        engine.controls.drive(Velocity(1))
    engine.controls.halt("enough")
    assert engine.heard == []


def test_an_engine_that_takes_input_gets_it_and_need_not_walk() -> None:
    engine = Engine(walks=False, takes_input=True)
    engine.controls.drive(Velocity(1))
    engine.controls.pass_on({"seq": 1})
    assert engine.heard == [Input({"seq": 1})]
    engine.gone = True
    engine.controls.pass_on({"seq": 2})
