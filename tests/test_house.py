"""The rules of the house, kept by machine."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.support.packages import packages

ROOT = Path(__file__).parents[1]
PACKAGES = tuple(f"{package}/" for package in packages())
GENERATED = ("openrois/adapter/components.py", "openrois/client/components.py")
MODULE_LINES, CLASS_LINES, METHODS = 500, 400, 25

# Each in two halves, so that this file does not hold them.
FORBIDDEN = {
    "a folder beside the repository": r"(?<![\w./-])\.{0,2}/?sha" + r"red/",
    "an absolute path of a workplace": r"(?<![\w.])/wo" + r"rk/|(?<![\w.])/ho" + r"me/|(?<![\w.])/ro" + r"ot/",
    "the host of a package registry": r"py"
    + r"pi\.org|python"
    + r"hosted\.org|registry\.np"
    + r"mjs\.org|registry\.ya"
    + r"rnpkg",
}


@cache
def tracked() -> tuple[str, ...]:
    """Return the paths of every tracked file that is there."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True, timeout=20)
    return tuple(path for path in listed.stdout.split("\0") if path and (ROOT / path).is_file())


def modules() -> list[str]:
    """Return the modules of the packages."""
    return [path for path in tracked() if path.endswith(".py") and path.startswith(PACKAGES)]


def python_files() -> list[str]:
    """Return every Python file, tests too."""
    return [path for path in tracked() if path.endswith(".py")]


@cache
def source(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


@cache
def text_of(path: str) -> str:
    """Return the text of a tracked file; what is no text has none."""
    try:
        return source(path)
    except UnicodeDecodeError:
        return ""


def docstring(path: str) -> str:
    """Return the first paragraph of a module's docstring, empty where there is none."""
    found = re.match(r'(?:#.*\n)*"""(.+?)(?:\n\n|"""|\Z)', source(path), re.DOTALL)
    return found[1].strip().replace("\n", " ") if found else ""


class TestArchitecture:
    def rows(self) -> dict[str, str]:
        """Return what ARCHITECTURE.md says of each path: lines of the form | `path` | sentence |."""
        found = re.findall(r"^\| `([^`]+)` \| (.+) \|$", source("ARCHITECTURE.md"), re.MULTILINE)
        assert len(found) == len(dict(found)), "a path stands twice"
        return dict(found)

    def test_every_module_has_its_sentence(self) -> None:
        missing = [path for path in modules() if path not in self.rows()]
        to_add = "\n".join(f"| `{path}` | {docstring(path)} |" for path in missing)
        assert not missing, f"ARCHITECTURE.md lacks:\n{to_add}"

    def test_every_sentence_is_of_something_that_is_there(self) -> None:
        gone = [path for path in self.rows() if not (ROOT / path).exists()]
        assert not gone, f"ARCHITECTURE.md names what is gone: {gone}"

    def test_every_sentence_is_one(self) -> None:
        assert [path for path, sentence in self.rows().items() if not sentence.endswith((".", ".)"))] == []


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


@pytest.mark.parametrize("what", FORBIDDEN)
def test_the_repository_speaks_of_the_product_alone(what: str) -> None:
    pattern = re.compile(FORBIDDEN[what])
    found = {path: match[0] for path in tracked() if (match := pattern.search(text_of(path)))}
    assert not found, what


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
