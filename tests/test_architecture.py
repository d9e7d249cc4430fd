"""ARCHITECTURE.md: its rooms and stations are those of the code, and its tables are printed from it."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.support.packages import ROOT, packages

PAGE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
TYPESCRIPT = ("web_demo/app", "web_demo/sdk")
NO_ROOMS = {"web_demo/app/styles"}
"""Folders that hold no module."""


def rooms() -> set[str]:
    """Return every package, and every folder of modules directly in one."""
    python = {str(path.parent.relative_to(ROOT)) for each in packages() for path in (ROOT / each).glob("*/__init__.py")}
    folders = {str(path.relative_to(ROOT)) for each in TYPESCRIPT for path in (ROOT / each).iterdir() if path.is_dir()}
    return {*packages(), *TYPESCRIPT, *python, *folders - NO_ROOMS}


def told_rooms() -> list[str]:
    """Return the rooms that the page has a paragraph for: folders in headings, and in the lists below them."""
    found, package = [], ""
    for mark, folder in re.findall(r"^(#+ |- )`([\w/]+)/`", PAGE, re.MULTILINE):
        package = package if mark == "- " else folder
        found.append(f"{package}/{folder}" if mark == "- " else folder)
    return found


def stations() -> list[tuple[str, str]]:
    """Return the stations of all journeys: a module, and a class, function or method in it."""
    return re.findall(r"^\d+\. `([\w/.]+\.\w+)` `([\w.#]+)`", PAGE, re.MULTILINE)


@cache
def names_in(path: str) -> frozenset[str]:
    """Return the classes and functions of a module, and methods as `Class.method`."""
    text = (ROOT / path).read_text(encoding="utf-8")
    return frozenset(python_names(text) if path.endswith(".py") else typescript_names(text))


def python_names(text: str) -> set[str]:
    found = set()
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            methods = (each for each in node.body if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef))
            found |= {f"{node.name}.{each.name}" for each in methods}
    return found


def typescript_names(text: str) -> set[str]:
    found = set(re.findall(r"^(?:export )?(?:abstract )?(?:class|function) (\w+)", text, re.MULTILINE))
    for name, body in re.findall(r"^export (?:abstract )?class (\w+).*?\{\n(.*?)^\}", text, re.DOTALL | re.MULTILINE):
        methods = re.findall(r"^  (?:protected )?(?:async )?(#?\w+)\(", body, re.MULTILINE)
        found |= {f"{name}.{method}" for method in methods}
    return found


def test_the_page_is_short() -> None:
    assert len(PAGE.encode()) <= 15_500


def test_every_room_has_its_paragraph() -> None:
    missing = rooms().difference(told_rooms())
    assert not missing, f"ARCHITECTURE.md says nothing of {sorted(missing)}"


def test_every_paragraph_is_of_a_room() -> None:
    told = told_rooms()
    gone = set(told) - rooms()
    assert not gone, f"ARCHITECTURE.md tells of folders that are gone or no rooms: {sorted(gone)}"
    assert len(told) == len(set(told)), "a room has two paragraphs"


def test_journeys_are_five() -> None:
    assert len(re.findall(r"^### .+\n\n(?:.+\n\n)?1\. ", PAGE, re.MULTILINE)) == 5


@pytest.mark.parametrize(("path", "name"), stations())
def test_a_station_is_in_the_code(path: str, name: str) -> None:
    assert (ROOT / path).is_file()
    assert name in names_in(path)


def test_no_station_escapes() -> None:
    steps = re.findall(r"^\d+\. .*", PAGE, re.MULTILINE)
    assert len(stations()) == len(steps) >= 40


def test_a_name_that_is_gone_is_found() -> None:
    assert "Relay.send" in names_in("signaling/openrois_signaling/relay.py")
    assert "Relay.gone" not in names_in("signaling/openrois_signaling/relay.py")
    assert "MediaPeer.apply" in names_in("web_demo/sdk/media/peer.ts")
    assert "MediaPeer.gone" not in names_in("web_demo/sdk/media/peer.ts")


def test_the_picture_is_there() -> None:
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", PAGE)
    assert len(pictures) == 1
    assert Path(ROOT / pictures[0]).is_file()
