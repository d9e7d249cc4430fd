"""A component outside of the standard, with a value of every type: no viewer can know it beforehand."""

import asyncio
from datetime import datetime
from typing import Annotated, Any, Final, cast

from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, EventType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.engine.registry import LocalRegistry
from openrois.errors import ComponentFailed
from openrois.types.codes import ComponentFunction, ErrorType
from openrois.types.messages import Result
from tests.support.fleet import NOON, Part, Robot

__all__ = ["KETTLE", "Boil", "Kettle", "kitchen"]


class KettleParameters(Payload):
    """One of every type."""

    target: Annotated[int, Data("int", description="degrees Celsius")] = 90
    ratio: Annotated[float, Data("double")] = 0.5
    keep_warm: Annotated[bool, Data("bool")] = False
    label: Annotated[str | None, Data("string", description="what is written on it")] = None
    wake_at: Annotated[datetime | None, Data("DateTime")] = None
    teas: Annotated[tuple[str, ...], Data("string[]")] = ("green", "black")
    minutes: Annotated[tuple[int, ...], Data("int[]")] = (3, 5)
    whistle: Annotated[str, Data("Kettle_Tune")] = "quiet"


class Boil(Payload):
    """How to boil."""

    degrees: Annotated[int, Data("int")]
    note: Annotated[str | None, Data("string")] = None


class Boiled(Payload):
    """How it went."""

    litres: Annotated[float, Data("double")]
    note: Annotated[str, Data("string")]
    at: Annotated[datetime, Data("DateTime")]


class Contents(Payload):
    """What is in it."""

    litres: Annotated[float, Data("double")]
    teas: Annotated[tuple[str, ...], Data("string[]")]


KETTLE: Final = ComponentType(
    code="Kettle",
    name="kettle",
    description="Boils water.",
    source="this file",
    function=ComponentFunction.ACTUATION,
    authority="Test",
    includes=(ROIS_COMMON,),
    commands=(
        CommandType("boil_water", "Boil.", arguments=Boil, results=Boiled, timeout=60_000),
        CommandType("burn_dry", "Break."),
    ),
    queries=(QueryType("water_inside", "Look.", Contents),),
    events=(EventType("water_boiled", "It boils.", Boiled),),
    parameters=KettleParameters,
)


class Kettle(Part):
    """A kettle: `boil_water` waits until it may end, notifies it and returns it; `burn_dry` breaks it."""

    def __init__(self, kind: ComponentType = KETTLE) -> None:
        super().__init__(kind)
        self.may_boil = asyncio.Event()
        self.may_boil.set()

    async def _run(self, command_type: str, texts: dict[str, str]) -> Payload | None:
        if command_type == "burn_dry":
            self.report(ErrorType.COMPONENT_INTERNAL_ERROR, "there is no water")
            raise ComponentFailed("there is no water")
        if command_type != "boil_water":
            return await super()._run(command_type, texts)
        await self.may_boil.wait()
        boil = Boil.from_texts(texts)
        boiled = Boiled(litres=1.5, note=boil.note or "", at=NOON)
        self.emit("water_boiled", boiled.named(Result))
        return boiled

    async def ask(self, query_type: str) -> tuple[Result, ...]:
        """Answer a query."""
        if query_type != "water_inside":
            return await super().ask(query_type)
        return Contents(litres=1.5, teas=("green", "black")).named(Result)


def kitchen(kettle: Kettle, engine_id: str = "kitchen") -> Robot:
    """Return a robot that is nothing but a kettle: `kitchen/kettle`."""
    return Robot(LocalRegistry(engine_id, cast(Any, (kettle,))), {"Kettle": kettle})
