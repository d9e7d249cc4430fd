"""The rules of the house, kept by machine."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "openrois/",
    "signaling/openrois_signaling/",
    "streaming/openrois_streaming/",
    "avatar_adapter/openrois_avatar/",
    "web_demo/openrois_web_demo/",
)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
MODULE_LINES, CLASS_LINES, METHODS, MAKEFILE_LINES = 400, 300, 20, 40

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
    """Return the modules of the five packages."""
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


@cache
def tree(path: str) -> ast.Module:
    return ast.parse(source(path))


class TestArchitecture:
    def rows(self) -> dict[str, str]:
        """Return what ARCHITECTURE.md says of each path: lines of the form | `path` | sentence |."""
        found = re.findall(r"^\| `([^`]+)` \| (.+) \|$", source("ARCHITECTURE.md"), re.MULTILINE)
        assert len(found) == len(dict(found)), "a path stands twice"
        return dict(found)

    def test_every_module_has_its_sentence(self) -> None:
        missing = [path for path in modules() if path not in self.rows()]
        to_add = "\n".join(f"| `{path}` | {self.summary(path)} |" for path in missing)
        assert not missing, f"ARCHITECTURE.md lacks:\n{to_add}"

    def test_every_sentence_is_of_something_that_is_there(self) -> None:
        gone = [path for path in self.rows() if not (ROOT / path).exists()]
        assert not gone, f"ARCHITECTURE.md names what is gone: {gone}"

    def test_every_sentence_is_one(self) -> None:
        assert [path for path, sentence in self.rows().items() if not sentence.endswith((".", ".)"))] == []

    def summary(self, path: str) -> str:
        return (ast.get_docstring(tree(path)) or "").partition("\n\n")[0].replace("\n", " ")


class TestSizes:
    def test_modules(self) -> None:
        long = {path: lines for path in modules() if (lines := len(source(path).splitlines())) > MODULE_LINES}
        assert not long, f"more than {MODULE_LINES} lines"

    def test_classes(self) -> None:
        for path in modules():
            for node in tree(path).body:
                if isinstance(node, ast.ClassDef):
                    lines = (node.end_lineno or node.lineno) - node.lineno + 1
                    assert lines <= CLASS_LINES, f"{path}: {node.name} has {lines} lines"
                    methods = [item.name for item in node.body if isinstance(item, FUNCTIONS)]
                    own = [name for name in methods if not name.startswith("__")]
                    assert len(own) <= METHODS, f"{path}: {node.name} has {len(own)} methods"

    def test_makefile(self) -> None:
        assert len(source("Makefile").splitlines()) <= MAKEFILE_LINES


class TestNames:
    def test_every_module_says_what_it_is_for(self) -> None:
        assert [path for path in modules() if not ast.get_docstring(tree(path))] == []

    def test_all_names_what_is_there(self) -> None:
        for path in modules():
            listed = exported(tree(path))
            missing = [name for name in listed if name not in set(bound(tree(path)))]
            assert not missing, f"{path}: __all__ names {missing}"
            assert len(listed) == len(set(listed)), f"{path}: __all__ names something twice"

    def test_the_control_plane_says_what_is_public(self) -> None:
        lacking = [
            path
            for path in modules()
            if path.startswith("openrois/")
            and not exported(tree(path))
            and any(isinstance(node, (*FUNCTIONS, ast.ClassDef)) for node in tree(path).body)
        ]
        assert lacking == []

    def test_no_class_is_named_after_nothing(self) -> None:
        vague = re.compile(r"(Manager|Helper|Utils?|Base|Impl|Wrapper|Processor)$")
        for path in python_files():
            classes = re.findall(r"^\s*class (\w+)", source(path), re.MULTILINE)
            assert [name for name in classes if vague.search(name)] == [], path

    def test_tests_are_no_packages(self) -> None:
        assert [path for path in tracked() if path.startswith("tests/") and path.endswith("__init__.py")] == []


def exported(module: ast.Module) -> list[str]:
    """Return what `__all__` lists, where there is one."""
    for node in module.body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            return [str(name) for name in ast.literal_eval(node.value)]
    return []


def bound(module: ast.Module) -> Iterator[str]:
    """Yield the names that a module binds at its top level."""
    for node in (inner for outer in module.body for inner in (outer, *ast.iter_child_nodes(outer))):
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.Import(names=names) | ast.ImportFrom(names=names):
                yield from (alias.asname or alias.name for alias in names)
            case ast.Name(id=name, ctx=ast.Store()):
                yield name


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
