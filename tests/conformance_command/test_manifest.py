"""The manifest: no link in it is dead, and nothing of the standard's catalog is left out."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from enum import StrEnum
from functools import cache
from pathlib import Path

import pytest
from openrois_conformance.checks import ALL_CHECKS
from openrois_conformance.manifest import Level, read_manifest

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.types import codes, messages, profiles
from openrois.types.methods import METHODS, NOTIFICATIONS

pytestmark = pytest.mark.extra(name="base")

ROOT = Path(__file__).parents[2]
EVERYTHING = [requirement for area in read_manifest() for requirement in area.requirements]
COVERED = {name for requirement in EVERYTHING for name in requirement.covers}


@cache
def nodes_in(path: Path) -> frozenset[str]:
    """Return the node ids of a file's tests, below `tests/`."""
    return frozenset(_nodes(ast.parse(path.read_text(encoding="utf-8")).body, str(path.relative_to(ROOT / "tests"))))


def _nodes(body: list[ast.stmt], prefix: str) -> Iterator[str]:
    for statement in body:
        if isinstance(statement, ast.ClassDef):
            yield from _nodes(statement.body, f"{prefix}::{statement.name}")
        elif isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef) and statement.name.startswith("test"):
            yield f"{prefix}::{statement.name}"


def test_every_id_stands_once() -> None:
    assert [name for name, count in Counter(requirement.id for requirement in EVERYTHING).items() if count > 1] == []
    assert [name for name, count in Counter(check.id for check in ALL_CHECKS).items() if count > 1] == []


def test_every_test_that_is_named_is_there() -> None:
    dead = []
    for requirement in EVERYTHING:
        for test in requirement.tests:
            path = ROOT / "tests" / test.partition("::")[0]
            if not path.is_file() or test not in nodes_in(path):
                dead.append(f"{requirement.id}: {test}")
    assert dead == []


def test_every_check_that_is_named_is_there_and_every_check_is_named() -> None:
    named = {check for requirement in EVERYTHING for check in requirement.checks}
    assert named ^ {check.id for check in ALL_CHECKS} == set()


def test_what_nothing_checks_says_why() -> None:
    assert [requirement.id for requirement in EVERYTHING if not requirement.is_checked and not requirement.gap] == []


def test_every_section_of_the_wire_that_is_named_is_there() -> None:
    for name in ("wire.md", "adapter-wire.md"):
        page = (ROOT / "docs" / "reference" / name).read_text(encoding="utf-8")
        headings = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
        named = {r.clause.removeprefix(f"{name}: ") for r in EVERYTHING if r.clause.startswith(f"{name}: ")}
        assert named
        assert named - set(headings) == set()


def test_the_standard_asks_by_its_clauses() -> None:
    """What the wire asks for is no `shall` of the standard."""
    strange = [
        r.id for r in EVERYTHING if r.level is Level.SHALL and r.clause.startswith(("wire.md", "adapter-wire.md"))
    ]
    assert strange == []


def test_requirements_and_checks_are_sentences() -> None:
    texts = [text for requirement in EVERYTHING for text in (requirement.text, requirement.gap) if text]
    texts += [check.title for check in ALL_CHECKS]
    assert [text for text in texts if not text.endswith(".") or text != text.strip()] == []


class TestCoverage:
    def test_methods(self) -> None:
        assert {method.name for method in METHODS} - COVERED == set()

    def test_notifications(self) -> None:
        assert {notification.name for notification in NOTIFICATIONS} - COVERED == set()

    def test_enumerations_and_their_members(self) -> None:
        for name in codes.__all__:
            members: type[StrEnum] = getattr(codes, name)
            assert name in COVERED
            text = next(requirement.text for requirement in EVERYTHING if name in requirement.covers)
            if name != "StreamStatus":
                assert [member.value for member in members if member.value not in text] == []

    def test_types(self) -> None:
        named = {"Result", "Parameter", "Argument", "CommandUnit", "ConcurrentCommands"}
        assert named <= set(messages.__all__)
        models = {name for name in profiles.__all__ if name[0].isupper()}
        assert (named | models) - COVERED == set()

    def test_components_and_their_messages(self) -> None:
        wanted = set()
        for kind in (ROIS_COMMON, *BASIC_COMPONENTS):
            names = [each.name for each in kind.commands]
            names += [each.name for each in kind.queries] + [each.name for each in kind.events]
            wanted |= {f"{kind.code}.{name}" for name in names}
        wanted |= {kind.code for kind in BASIC_COMPONENTS}
        wanted |= {f"{kind.code}.parameters" for kind in BASIC_COMPONENTS if kind.parameters is not None}
        assert wanted - COVERED == set()

    def test_nothing_is_covered_that_is_not_there(self) -> None:
        known = {method.name for method in METHODS} | {notification.name for notification in NOTIFICATIONS}
        known |= set(codes.__all__) | set(messages.__all__) | set(profiles.__all__)
        strange = {name for name in COVERED - known if "." not in name or name.startswith("rois.")}
        assert strange - {kind.code for kind in BASIC_COMPONENTS} == set()
