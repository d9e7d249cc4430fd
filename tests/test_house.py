"""The rules of the house, kept by machine."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.support.imports import import_graph
from tests.support.packages import ROOT, modules, tracked

GENERATED = ("openrois/adapter/components.py", "openrois/client/components.py")
MODULE_LINES, CLASS_LINES, METHODS = 500, 400, 25


def python_files() -> list[str]:
    """Return every Python file, tests too."""
    return [path for path in tracked() if path.endswith(".py")]


@cache
def source(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def docstring(path: str) -> str:
    """Return the first paragraph of a module's docstring, empty where there is none."""
    found = re.match(r'(?:#.*\n)*"""(.+?)(?:\n\n|"""|\Z)', source(path), re.DOTALL)
    return found[1].strip().replace("\n", " ") if found else ""


class TestSizes:
    def test_modules(self) -> None:
        written = [path for path in modules() if path not in GENERATED]
        long = {path: lines for path in written if (lines := len(source(path).splitlines())) > MODULE_LINES}
        assert not long, f"more than {MODULE_LINES} lines"

    def test_classes(self) -> None:
        for path in modules():
            for name, body in re.findall(r"^class (\w+)((?:.*\n)(?:[ \t)].*\n|\n)*)", source(path), re.MULTILINE):
                lines = len(body.rstrip().splitlines())
                assert lines <= CLASS_LINES, f"{path}: {name} has {lines} lines"
                methods = re.findall(r"^    (?:async )?def (?!__)(\w+)", body, re.MULTILINE)
                assert len(methods) <= METHODS, f"{path}: {name} has {len(methods)} methods"


class TestRooms:
    @pytest.mark.parametrize(
        ("package", "most"),
        [("openrois", 8), ("streaming/openrois_streaming", 8), ("avatar_adapter/openrois_avatar", 4)],
    )
    def test_a_package_has_few_modules_beside_its_rooms(self, package: str, most: int) -> None:
        beside = [path for path in modules() if str(Path(path).parent) == package and not path.endswith("__init__.py")]
        assert len(beside) <= most

    def test_a_room_says_what_it_owns(self) -> None:
        assert [path for path in modules() if path.endswith("/__init__.py") and len(docstring(path)) < 20] == []


class TestNames:
    def test_every_module_says_what_it_is_for(self) -> None:
        assert [path for path in modules() if not docstring(path)] == []

    def test_all_names_what_is_there(self) -> None:
        for path in modules():
            text = source(path)
            listed = exported(text)
            missing = [name for name in listed if not binds(text, name)]
            assert not missing, f"{path}: __all__ names {missing}"
            assert len(listed) == len(set(listed)), f"{path}: __all__ names something twice"

    def test_the_control_plane_says_what_is_public(self) -> None:
        public = re.compile(r"^(?:async def|def|class) [a-z]", re.MULTILINE | re.IGNORECASE)
        ours = [path for path in modules() if path.startswith("openrois/") and public.search(source(path))]
        assert [path for path in ours if not exported(source(path))] == []

    def test_no_class_is_named_after_nothing(self) -> None:
        vague = re.compile(r"(Manager|Helper|Utils?|Base|Impl|Wrapper|Processor)$")
        for path in python_files():
            classes = re.findall(r"^\s*class (\w+)", source(path), re.MULTILINE)
            assert [name for name in classes if vague.search(name)] == [], path

    def test_tests_are_no_packages(self) -> None:
        assert [path for path in tracked() if path.startswith("tests/") and path.endswith("__init__.py")] == []


def exported(text: str) -> list[str]:
    """Return what `__all__` lists, where there is one."""
    found = re.search(r"^__all__(?:: [^=]+)? = [\[(](.*?)[\])]", text, re.DOTALL | re.MULTILINE)
    return re.findall(r'"(\w+)"', found[1]) if found else []


def binds(text: str, name: str) -> bool:
    """Tell whether a module binds a name: as function, class, variable or import."""
    ways = (
        rf"(?:async def|def|class) {name}\b",
        rf"{name}\b[^\n=]*=",
        rf"(?: {{4}})?(?:from .+ )?import .*\b{name}\b",
        rf"    {name},$",
    )
    return re.search("|".join(f"^(?:{way})" for way in ways), text, re.MULTILINE) is not None


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = import_graph()
    left = {each: graph.find_modules_directly_imported_by(each) for each in graph.modules}
    # What imports nothing that is left is in no circle.
    while done := {each for each, imported in left.items() if not imported & left.keys()}:
        left = {each: imported for each, imported in left.items() if each not in done}
    # Nor is what no module that is left imports.
    while done := left.keys() - {one for imported in left.values() for one in imported}:
        left = {each: imported for each, imported in left.items() if each not in done}
    assert sorted(left) == []


def test_imports_go_in_the_directions_that_were_agreed() -> None:
    checked = subprocess.run(
        [Path(sys.executable).with_name("lint-imports")],
        cwd=ROOT,
        capture_output=True,
        check=False,
        text=True,
        timeout=60,
    )
    assert checked.returncode == 0, checked.stdout
