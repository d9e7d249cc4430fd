"""The pages about the simulated robot say what the code does."""

import dataclasses
import re
import textwrap
from math import dist
from pathlib import Path
from typing import Any

import pytest
from openrois_body.motion.wayfinding import BODY
from openrois_body.vision.box import FIELD_OF_VIEW
from openrois_robots.simulated import camera, driving, physics, simulation
from openrois_robots.simulated.battery import BatterySettings
from openrois_robots.simulated.drawing import renderer
from openrois_robots.simulated.driving import BaseSettings
from openrois_robots.simulated.world import visitor
from openrois_robots.simulated.world.plan import APARTMENT

from openrois.client.components import Navigation, SpeechSynthesis
from openrois.errors import RoISError
from tests.support.simulated_robot import staged

DOCS = Path(__file__).parents[2] / "docs"
TABLES: dict[str, type[BaseSettings] | type[BatterySettings]] = {"base": BaseSettings, "battery": BatterySettings}


def text_of(page: str) -> str:
    return " ".join((DOCS / page).read_text(encoding="utf-8").split())


def rows() -> list[tuple[str, str, float, float, float]]:
    """Return table, key, default, least and most of each row."""
    page = (DOCS / "reference/simulated-robot.md").read_text(encoding="utf-8")
    found = re.findall(r"^\| `(\w+)\.(\w+)` \|[^|]*\| ([\d.]+) \| ([\d.]+), ([\d.]+) \|", page, re.MULTILINE)
    return [(table, key, *map(float, numbers)) for table, key, *numbers in found]


def test_the_table_has_every_setting_with_its_default() -> None:
    known = {(table, each.name, each.default) for table, kind in TABLES.items() for each in dataclasses.fields(kind)}
    assert {(table, key, default) for table, key, default, *_ in rows()} == known


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row[0]}.{row[1]}")
def test_the_table_has_the_bounds(row: tuple[str, str, float, float, float]) -> None:
    table, key, _, least, most = row
    kind = TABLES[table]
    # A battery that lasts longer when it drives is refused for another reason.
    others = {"standing": 100_000.0} if key == "driving" else {"driving": 0.1} if key == "standing" else {}
    for value in (least, most):
        kind(**{**others, key: value})
    for value in (least - 0.01, most + 0.01):
        with pytest.raises(ValueError, match=rf"{table}\.{key} must be between"):
            kind(**{**others, key: value})


@pytest.mark.parametrize(
    "sentence",
    [
        f"round, {physics.RADIUS} m in radius",
        f"looks {simulation._AHEAD:g} m ahead",
        f"without {driving._PROGRESS * 100:g} cm of progress in {driving.STUCK:g} s",
        f"ways keep {BODY} m from all it has",
        f"goes at {visitor._SPEED} m/s, stands {visitor._PAUSE:g} s at each of five points",
        f"nearer than {visitor._APART} m",
        f"{renderer.CAMERA_HEIGHT} m above the floor, sees {FIELD_OF_VIEW * 57.29578:.0f} degrees",
        f"looks {-simulation._LEVEL} rad down",
        f"turns its camera: {simulation._PAN} rad to each side, {simulation._TILT} rad up and down",
    ],
)
def test_the_reference_has_the_figures_of_the_code(sentence: str) -> None:
    assert sentence in text_of("reference/simulated-robot.md")


def test_the_guide_has_the_figures_of_the_code() -> None:
    guide = text_of("how-to/simulated-robot.md")
    assert f"{camera.SIZE[0]}x{camera.SIZE[1]} at {camera.FRAME_RATE:.0f} pictures a second" in guide
    assert f"below {100 * BatterySettings().low:.0f} per cent" in guide
    assert len(APARTMENT.round) == 5
    for name in ("reader", "cook", "clerk", "dock"):
        assert name in {thing.name for thing in APARTMENT.things}
        assert f"`{name}`" in guide


def example() -> str:
    """Return the body of the guide's program, in which a client is connected."""
    page = (DOCS / "how-to/simulated-robot.md").read_text(encoding="utf-8")
    program = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert program is not None
    _, _, body = program[1].partition(" as client:\n")
    return textwrap.dedent(body)


async def test_the_program_of_the_guide_does_what_it_says() -> None:
    program = f"async def run(client):\n{textwrap.indent(example(), '    ')}"
    names: dict[str, Any] = {"Navigation": Navigation, "SpeechSynthesis": SpeechSynthesis}
    exec(program, names)
    async with staged() as stage:
        await stage.until(names["run"](stage.client))
        reader = APARTMENT.persons[0].place
        assert dist((stage.place.x, stage.place.y), (reader.x, reader.y)) < 0.85


def refusals() -> list[tuple[str, str]]:
    """Return the targets of the guide's table, and what is said of each."""
    page = (DOCS / "how-to/simulated-robot.md").read_text(encoding="utf-8")
    return re.findall(r'^\| `"([^"]+)"` \| `([^`]+)`', page, re.MULTILINE)


def without_distance(text: str) -> str:
    """Return a sentence without how far it was: another processor may round otherwise."""
    return re.sub(r"stuck \d\.\d\d m", "stuck", text)


@pytest.mark.parametrize(("target", "said"), refusals())
async def test_the_refusals_of_the_guide_are_the_robots(target: str, said: str) -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)

        async def go() -> None:
            await navigation.set(target_positions=[target])
            await stage.client.run(navigation.start())

        async with navigation.bound():
            with pytest.raises(RoISError) as raised:
                await stage.until(go())
    assert without_distance(said).removesuffix(", ...") in without_distance(str(raised.value))
