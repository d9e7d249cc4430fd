"""docs/how-to/adapter.md: every piece of Python in it runs, and its tests pass."""

import asyncio
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

from openrois.testing import ComponentContract, harness

pytestmark = pytest.mark.extra(name="demo")

ROOT = Path(__file__).parents[3]
GUIDE = (ROOT / "docs" / "how-to" / "adapter.md").read_text(encoding="utf-8")
PIECES = re.findall(r"^```python\n(.*?)^```$", GUIDE, re.DOTALL | re.MULTILINE)


def written() -> dict[str, Any]:
    """Return what all pieces define, one after the other."""
    defined: dict[str, Any] = {"__name__": "guide"}
    for number, piece in enumerate(PIECES):
        exec(compile(piece, f"docs/how-to/adapter.md, piece {number}", "exec"), defined)
    return defined


@pytest.fixture(scope="module")
def guide() -> dict[str, Any]:
    return written()


def test_the_example_is_the_file(guide: dict[str, Any]) -> None:
    example = (ROOT / "docs" / "examples" / "lamp_adapter.py").read_text(encoding="utf-8")
    assert example.endswith(PIECES[0])


def test_its_tests_pass(guide: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    tests = [value for name, value in guide.items() if name.startswith("test_")]
    assert len(tests) == 2
    for test in tests:
        asyncio.run(test())


def test_its_components_keep_the_contract(guide: dict[str, Any]) -> None:
    contracts = [
        value
        for value in guide.values()
        if inspect.isclass(value) and issubclass(value, ComponentContract) and value is not ComponentContract
    ]
    assert [each.__name__ for each in contracts] == ["TestLamp", "TestBase"]
    for contract in contracts:
        for name in dir(contract):
            if name.startswith("test_"):
                getattr(contract(), name)()


async def test_a_class_of_the_standard_answers_a_query_of_its_own(guide: dict[str, Any]) -> None:
    async with harness(guide["LampInformation"](), engine_id="lamp_1") as client:
        assert await client.component("lamp_1/system_info").query("battery") == {"battery": 87.5}


async def test_what_it_says_of_values(guide: dict[str, Any]) -> None:
    arm = guide["Arm"]("arm")
    (reach,) = arm.profile.command_profiles
    assert [(each.name, each.description) for each in reach.arguments] == [
        ("x", "metres to the right"),
        ("y", "metres ahead"),
        ("force", "newtons to press with"),
    ]
    assert [each.name for each in reach.results] == ["x", "y", "gripping"]
    assert reach.timeout == 20_000
    scale = guide["Scale"]("scale", "/dev/ttyUSB0")
    assert scale.status.value == "UNINITIALIZED"
    await scale.bring_up()
    assert scale.status.value == "READY"
