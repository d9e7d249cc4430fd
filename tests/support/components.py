"""Small components with real behaviour for tests of the control plane."""

import asyncio

from openrois.component import COMMON_QUERIES, Component, command, parameter_profile, query
from openrois.errors import ComponentFailed, TimedOut
from openrois.types.codes import ComponentFunction
from openrois.types.messages import Result
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    QueryMessageProfile,
    RoISIdentifier,
    component_urn,
)


def text(name: str, value: str) -> Result:
    return Result(name=name, data_type_ref="string", value=value)


class Lamp(Component):
    """An actuation: glows in a colour, counts its switches, and can be told to fail, to time out or to wait."""

    def __init__(self, name: str = "lamp") -> None:
        super().__init__(
            HRIComponentProfile(
                identifier=RoISIdentifier(code=component_urn("Lamp", "Test")),
                name=name,
                function=ComponentFunction.ACTUATION,
                command_profiles=(
                    CommandMessageProfile(name="start"),
                    CommandMessageProfile(name="stop"),
                    CommandMessageProfile(
                        name="switch",
                        arguments=(parameter_profile("times", "int"), parameter_profile("note", "string")),
                        results=(parameter_profile("total", "int"),),
                    ),
                    CommandMessageProfile(name="fail"),
                    CommandMessageProfile(name="time_out"),
                    CommandMessageProfile(name="crash"),
                ),
                query_profiles=(*COMMON_QUERIES, QueryMessageProfile(name="brightness")),
                event_profiles=(EventMessageProfile(name="switched", results=(parameter_profile("total", "int"),)),),
                parameter_profiles=(
                    parameter_profile("colour", "string", "white"),
                    parameter_profile("level", "int", "5"),
                ),
            )
        )
        self.total = 0
        self.glowing = asyncio.Event()
        self.may_end = asyncio.Event()

    @command("switch")
    async def switch(self, arguments: dict[str, str]) -> tuple[Result, ...]:
        self.total += int(arguments.get("times", "1"))
        result = Result(name="total", data_type_ref="int", value=str(self.total))
        self.emit("switched", (result,))
        return (result,)

    @command("start")
    async def start(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        self.glowing.set()
        try:
            await self.may_end.wait()
        finally:
            self.glowing.clear()
        return ()

    @command("fail")
    async def fail(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        raise ComponentFailed("the bulb is gone")

    @command("time_out")
    async def time_out(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        raise TimedOut("too slow")

    @command("crash")
    async def crash(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        raise ZeroDivisionError("a bug")

    @query("brightness")
    async def brightness(self) -> tuple[Result, ...]:
        return (Result(name="level", data_type_ref="int", value=self.parameters["level"]),)


class Bell(Component):
    """A sensing component that needs no bind: rings when a test tells it to."""

    def __init__(self, name: str = "bell") -> None:
        super().__init__(
            HRIComponentProfile(
                identifier=RoISIdentifier(code=component_urn("Bell", "Test")),
                name=name,
                function=ComponentFunction.SENSING,
                query_profiles=COMMON_QUERIES,
                event_profiles=(EventMessageProfile(name="rang", results=(parameter_profile("tune", "string"),)),),
            )
        )

    def ring(self, tune: str) -> None:
        self.emit("rang", (text("tune", tune),))
