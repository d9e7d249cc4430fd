"""A component whose condition and commands are set by the test, and a device that connects when it is let."""

import asyncio

from openrois.component.authoring.marks import command, event, query
from openrois.component.authoring.parameters import parameter
from openrois.component.component import Component
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument


def argument(name: str, value: str) -> Argument:
    return Argument(name=name, data_type_ref="ignored", value=value)


class Thing(Component):
    """Its condition and what `start` and `dawdle` do are set by the test."""

    def __init__(self) -> None:
        super().__init__("thing")
        self.is_in = ComponentStatus.READY
        self.starts: list[str] = []
        self.begun = asyncio.Event()
        self.may_end = asyncio.Event()
        self.stopped = 0

    def condition(self) -> ComponentStatus:
        return self.is_in

    @query
    async def shape(self) -> str:
        return "round"

    @command
    async def start(self) -> None:
        self.starts.append("begins")
        self.begun.set()
        try:
            await self.may_end.wait()
        finally:
            self.starts.append("ends")

    @command
    async def stop(self) -> None:
        self.stopped += 1

    @command
    async def pause(self) -> None: ...

    @command(timeout=0.001)
    async def dawdle(self) -> None:
        await asyncio.Event().wait()


async def began(thing: Thing) -> None:
    async with asyncio.timeout(60):
        await thing.begun.wait()


class Device(Component):
    """Connects when it is let, as often as it takes."""

    tempo: int = parameter(60)

    def __init__(self, *outcomes: Exception | None) -> None:
        self.outcomes = list(outcomes)
        self.calls: list[str] = []
        self.started = asyncio.Event()

    async def connect(self) -> None:
        self.calls.append("connect")
        outcome = self.outcomes.pop(0)
        if outcome is not None:
            raise outcome

    async def disconnect(self) -> None:
        self.calls.append("disconnect")

    @command
    async def start(self) -> None:
        self.calls.append("start")
        self.started.set()
        await asyncio.Event().wait()

    @event
    def beat(self) -> None: ...
