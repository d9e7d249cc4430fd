"""The page about the Kachaka says what the code does."""

import dataclasses
import re
import textwrap
import tomllib
from pathlib import Path
from typing import Any

import pytest
from openrois_robots.adapter.battery import BatteryLimit
from openrois_robots.adapter.link import PATIENCE, PERIOD
from openrois_robots.kachaka import driver, limits, plan
from openrois_robots.kachaka.api.address import PORT
from openrois_robots.kachaka.simulator.house import HOUSE

from openrois.client.components import Navigation, SpeechSynthesis
from tests.support.kachaka import staged

pytestmark = pytest.mark.extra(name="kachaka")

PAGE = (Path(__file__).parents[3] / "docs/how-to/kachaka.md").read_text(encoding="utf-8")
TABLES: dict[str, Any] = {
    "driving": limits.DrivingLimits,
    "speech": limits.SpeechSettings,
    "battery": BatteryLimit,
}


def fenced(language: str) -> str:
    """Return what stands in the page between fences of a language."""
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def test_the_file_has_every_key_with_its_default() -> None:
    document = tomllib.loads(fenced("toml"))
    assert document.pop("robot").keys() == {"address"}
    assert document.keys() == TABLES.keys()
    for name, kind in TABLES.items():
        assert document[name] == dataclasses.asdict(kind()), name


@pytest.mark.parametrize(
    "sentence",
    [
        f"the port is {PORT} unless it says another",
        f"m/s of move and by hand, 0.05 to {limits.LINEAR:g}",
        f"rad/s by hand, 0.05 to {limits.ANGULAR:g}",
        f"a picture of {plan._MOST_PIXELS} pixels at most",
        f"noticed within {PERIOD + PATIENCE:g} s",
        "six locations, two shelves, two cameras and two persons",
    ],
)
def test_it_has_the_figures_of_the_code(sentence: str) -> None:
    assert sentence in " ".join(PAGE.split())
    assert driver.HOLD == 0.5
    assert (len(HOUSE.locations), len(HOUSE.shelves), len(HOUSE.persons)) == (6, 2, 2)


async def test_its_program_does_what_it_says() -> None:
    _, _, body = fenced("python").partition(" as client:\n")
    body = textwrap.dedent(body).replace("kachaka/%", "robot/%")
    names: dict[str, Any] = {"Navigation": Navigation, "SpeechSynthesis": SpeechSynthesis}
    exec(f"async def run(client):\n{textwrap.indent(body, '    ')}", names)
    async with staged() as stage:
        await names["run"](stage.client)
        assert stage.simulation.premises.is_docked
        assert stage.simulation.last is not None
        assert stage.simulation.last.command.speak_command.text == "I am back."
