"""The extras: the table of the code is that of the project, and each is described where users read."""

import ast
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from openrois.extras import EXTRAS
from tests.support.kachaka_api import needs_kachaka
from tests.support.packages import NOT_SHIPPED, ROOT, packages

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BROUGHT = {
    "cryptography": "pyjwt",
    "grpc": "kachaka-api",
    "ifaddr": "aioice",
    "livekit": "livekit-agents",
    "mcp_types": "mcp",
    "pipecat": "pipecat-ai",
    "pylibsrtp": "aiortc",
    "starlette": "mcp",
    "uvicorn": "mcp",
}
"""Modules of distributions that come with another one, and which that is."""
FOR_DEVELOPERS = {"dev", "docs"}
"""Extras for a clone, which the product does not look for."""
OF_TESTS = {"psutil", "pytest", "tests"}
"""Modules that testers have: for the pytest plugin, and for the benchmarks that compare with other programs."""


def distributions(extra: str) -> Iterator[str]:
    """Yield the distributions that an extra asks for, with those of the extras that it includes."""
    for requirement in map(Requirement, PROJECT["optional-dependencies"][extra]):
        if requirement.name != PROJECT["name"]:
            yield canonicalize_name(requirement.name)
        for included in requirement.extras if requirement.name == PROJECT["name"] else ():
            yield from distributions(included)


@needs_kachaka
def test_the_table_of_the_code_is_that_of_the_project() -> None:
    providers = packages_distributions()
    assert set(EXTRAS) == set(PROJECT["optional-dependencies"]) - FOR_DEVELOPERS
    for extra, modules in EXTRAS.items():
        named = {BROUGHT.get(module) or canonicalize_name(providers[module][0]) for module in modules}
        assert named == set(distributions(extra)), extra


def test_a_plain_installation_is_two_libraries() -> None:
    assert {Requirement(text).name for text in PROJECT["dependencies"]} == {"pydantic", "websockets"}


def imported() -> set[str]:
    """Return the top-level modules that the shipped packages import, but the standard library's and their own."""
    ours = {Path(package).name for package in packages()}
    found = set()
    for package in set(packages()) - NOT_SHIPPED:
        for path in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
                names += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
                found |= {name.partition(".")[0] for name in names}
    return found - ours - sys.stdlib_module_names


def test_every_library_that_is_imported_is_one_of_an_extra_or_of_all() -> None:
    known = {module for modules in EXTRAS.values() for module in modules}
    assert imported() - OF_TESTS == known | {"pydantic", "pydantic_core", "websockets"}


def test_a_smaller_extra_stands_before_those_that_include_it() -> None:
    order = list(EXTRAS)
    for extra in order:
        for text in PROJECT["optional-dependencies"][extra]:
            requirement = Requirement(text)
            if requirement.name == PROJECT["name"]:
                assert all(order.index(included) < order.index(extra) for included in requirement.extras)
