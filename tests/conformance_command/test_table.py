"""The manifest as text, as Markdown and as JSON, of two small areas."""

import pytest
from openrois_conformance.manifest import Area, Level, Requirement
from openrois_conformance.table import as_json, as_markdown, as_text, checked_by, counted

pytestmark = pytest.mark.extra(name="base")

FULL = Requirement("a.full", "It is | so.", "8.2", Level.SHALL, checks=("one", "two"), tests=("test_x.py::test_y",))
LACKING = Requirement("a.lacking", "It is not so.", "8.3", Level.SHOULD, gap="It was not needed.")
OTHER = Requirement("b.other", "It is elsewhere.", "wire.md: The base", Level.WIRE, tests=("a", "b"))
AREAS = (Area("a", "First things", (FULL, LACKING)), Area("b", "Other things", (OTHER,)))


def test_words() -> None:
    assert (counted(1, "test"), counted(0, "test")) == ("1 test", "0 tests")
    assert [checked_by(requirement) for requirement in (FULL, LACKING, OTHER)] == ["2 checks, 1 test", "gap", "2 tests"]


def test_text() -> None:
    lines = list(as_text(AREAS, 60))
    assert lines[:3] == ["First things", "------------", "a.full     shall      8.2  2 checks, 1 test"]
    assert "    gap: It was not needed." in lines
    assert "3 requirements: 1 shall, 1 should, 1 wire, 0 extension" in lines
    assert lines[-1] == "      a.lacking: It was not needed."


def test_markdown() -> None:
    lines = list(as_markdown(AREAS))
    assert "| [First things](#first-things) | 2 | 1 | 1 | 1 |" in lines
    assert "| all | 3 | 1 | 2 | 1 |" in lines
    assert "| `a.lacking` | It is not so. **It was not needed.** |" in lines
    assert "| `a.full` | It is \\| so. | 8.2 | shall | `one`, `two` | 1 |" in lines
    assert "| `b.other` | It is elsewhere. | wire.md: The base | wire |  | 2 |" in lines


def test_json() -> None:
    (first, other) = as_json(AREAS)["areas"]
    assert (first["name"], other["title"]) == ("a", "Other things")
    assert [requirement["id"] for requirement in first["requirements"]] == ["a.full", "a.lacking"]
