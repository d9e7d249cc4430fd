"""Small components with real behaviour for tests of the control plane."""

import asyncio

from openrois.component.authoring.marks import command, event, query
from openrois.component.authoring.parameters import parameter
from openrois.component.component import DEAD_MAN, Component
from openrois.errors import ComponentFailed, TimedOut
from openrois.types.messages import Result


def text(name: str, value: str) -> Result:
    return Result(name=name, data_type_ref="string", value=value)


class Lamp(Component, authority="Test", function="actuation"):
    """An actuation: glows in a colour, counts its switches, and has commands that fail, time out or wait."""

    colour: str = parameter("white")
    level: int = parameter(5)

    def __init__(self, name: str = "lamp") -> None:
        super().__init__(name)
        self.total = 0
        self.glowing = asyncio.Event()
        self.may_end = asyncio.Event()

    @command
    async def start(self) -> None:
        self.glowing.set()
        try:
            await self.may_end.wait()
        finally:
            self.glowing.clear()

    @command
    async def stop(self) -> None:
        pass

    @command(result="total")
    async def switch(self, times: int = 1, note: str = "") -> int:
        self.total += times
        self.switched(self.total)
        return self.total

    @command
    async def fail(self) -> None:
        raise ComponentFailed("the bulb is gone")

    @command
    async def time_out(self) -> None:
        raise TimedOut("too slow")

    @command
    async def crash(self) -> None:
        raise ZeroDivisionError("a bug")

    @query(result="level")
    async def brightness(self) -> int:
        return self.level

    @event
    def switched(self, total: int) -> None: ...


class Rover(Component, authority="Test", function="actuation"):
    """Drives until it is stopped, and only while an application is in control; its brake can be broken."""

    dead_man = DEAD_MAN

    def __init__(self) -> None:
        super().__init__("rover")
        self.driving = asyncio.Event()
        self.stopped = asyncio.Event()
        self.fails = False

    @command
    async def start(self) -> None:
        self.driving.set()
        await asyncio.Event().wait()

    @command
    async def turn(self) -> None:
        self.driving.set()
        await asyncio.Event().wait()

    @command
    async def stop(self) -> None:
        self.stopped.set()
        if self.fails:
            raise ComponentFailed("the brake is broken")


class Bell(Component, authority="Test", function="sensing"):
    """A sensing component that needs no bind: rings when a test calls `ring`."""

    @event
    def rang(self, tune: str) -> None: ...

    def ring(self, tune: str) -> None:
        self.rang(tune)
