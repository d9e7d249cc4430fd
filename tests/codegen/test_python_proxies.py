"""Proxies for types that are not the standard's: what the basic components do not show."""

import sys
from dataclasses import replace
from types import ModuleType
from typing import Annotated

import pytest
from openrois_codegen.python_proxies import emit

from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import CommandType, ComponentType, QueryType
from openrois.catalog.payload import Data, Payload


class PourArguments(Payload):
    """What to pour."""

    drink: Annotated[str, Data(description="which drink")]
    cups: Annotated[int, Data(description="how many cups")] = 1
    extras: Annotated[tuple[str, ...] | None, Data(description="what goes into it")] = None


class PourResults(Payload):
    """What was poured."""

    millilitres: int
    temperature: float


class LevelResult(Payload):
    """How much is left."""

    left: Annotated[float, Data(description="the litres that are left")]


class BaristaParametersWithAVeryLongNameThatDoesNotFitIntoALine(Payload):
    """How to work."""

    strength: Annotated[int, Data(description="how strong, 1 to 5")] = 3


BARISTA = ComponentType(
    code="Barista",
    name="barista",
    description="Makes coffee.",
    source="the test",
    authority="Test",
    commands=(
        CommandType("pour", "Pour a drink.", PourArguments, PourResults),
        CommandType("rinse", "Clean the machine."),
    ),
    queries=(QueryType("level", "Ask how much is left.", LevelResult),),
    parameters=BaristaParametersWithAVeryLongNameThatDoesNotFitIntoALine,
    includes=(ROIS_COMMON,),
)


@pytest.fixture
def catalog(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put the type into a module of the catalog, where types are looked for."""
    module = ModuleType("openrois.catalog.coffee")
    module.__dict__.update(BARISTA=BARISTA, __all__=["BARISTA"])
    monkeypatch.setitem(sys.modules, module.__name__, module)


@pytest.mark.usefixtures("catalog")
def test_what_is_only_read_cannot_be_set(monkeypatch: pytest.MonkeyPatch) -> None:
    class Levels(Payload):
        """What there is."""

        beans: Annotated[int, Data(description="grams of beans", read_only=True)] = 0

    class Settings(Levels):
        """How to work."""

        strength: Annotated[int, Data(description="how strong")] = 3

    for parameters, setter in (
        (Levels, None),
        (Settings, "    def set(self, *, strength: int | None = None) -> Step[None]:"),
    ):
        barista = replace(BARISTA, parameters=parameters)
        monkeypatch.setattr(sys.modules["openrois.catalog.coffee"], "BARISTA", barista)
        written = emit([barista])
        compile(written, "components.py", "exec")
        assert f"    async def parameters(self) -> {parameters.__name__}:" in written
        assert "beans" not in written
        assert [line for line in written.splitlines() if "def set(" in line] == ([setter] if setter else [])


@pytest.mark.usefixtures("catalog")
def test_arguments_results_and_defaults() -> None:
    written = emit([BARISTA])
    compile(written, "components.py", "exec")
    assert "from openrois.catalog.coffee import BARISTA\n" in written
    assert '__all__ = [\n    "Barista",\n    "RoISCommon",\n]\n' in written
    assert written.index("class RoISCommon(ComponentProxy):") < written.index("class Barista(RoISCommon):")
    assert (
        """
    def pour(
        self, *, drink: str, cups: int | None = None, extras: list[str] | tuple[str, ...] | None = None
    ) -> Step[PourResults]:
        \"\"\"Pour a drink.

        Args:
            drink: which drink.
            cups: how many cups.
            extras: what goes into it.
        \"\"\"
        return self.command("pour", PourResults, drink=drink, cups=cups, extras=extras)

    def rinse(self) -> Step[None]:
        \"\"\"Clean the machine.\"\"\"
        return self.command("rinse", None)

    async def level(self) -> float:
        \"\"\"Ask how much is left.

        Returns:
            The litres that are left.
        \"\"\"
        return (await self.query("level", LevelResult)).left
"""
        in written
    )


def test_a_type_that_stands_nowhere_cannot_be_imported() -> None:
    with pytest.raises(LookupError, match="Barista is the object of no module"):
        emit([BARISTA])
