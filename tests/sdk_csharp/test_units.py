"""The parts of the client for C#, each alone: strands, feeds, sessions over sockets in memory, values, negotiation."""

import json
import re
from pathlib import Path
from typing import Final

import pytest

from tests.support.corpus import FOLDER
from tests.support.mono import Mono, sdk_sources
from tests.support.once import once

UNITS: Final = Path(__file__).with_name("units")


def names() -> list[str]:
    """Return the tests that the sources have."""
    found = []
    for path in sorted(UNITS.glob("*Tests.cs")):
        for name, body in re.findall(
            r"^public static class (\w+Tests)\n\{(.+?)^\}", path.read_text(), re.DOTALL | re.MULTILINE
        ):
            found += [
                f"{name}.{test}"
                for test in re.findall(r"^    public static (?:async )?(?:void|Task) (\w+)\(\)", body, re.MULTILINE)
            ]
    return found


@pytest.fixture(scope="module")
def told(mono: Mono, csharp_folder: Path) -> dict[str, str | None]:
    """What came of each test."""
    sources = [*sdk_sources(), *UNITS.glob("*.cs")]
    made = csharp_folder / "units.exe"
    program = once(made, lambda new: mono.build(new, sources, "-r:System.Runtime.Serialization"))
    lines = [json.loads(line) for line in mono.run(program, str(FOLDER / "values" / "values.json")).splitlines()]
    return {line["test"]: line["failure"] for line in lines}


def test_no_test_is_left_out(told: dict[str, str | None]) -> None:
    assert sorted(told) == sorted(names())


@pytest.mark.parametrize("name", names())
def test_part(told: dict[str, str | None], name: str) -> None:
    assert told[name] is None, told[name]
