"""The requirements manifest: every clause of the standard and of the wire, and how each is checked. Pure."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from importlib.resources import files
from typing import Any, Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import ComponentType

__all__ = ["Area", "Level", "Requirement", "check_of_type", "read_manifest"]


class Level(StrEnum):
    """The source of a requirement, and how firm it is."""

    SHALL = "shall"
    SHOULD = "should"
    WIRE = "wire"
    EXTENSION = "extension"


@dataclass(frozen=True, slots=True)
class Requirement:
    """One requirement.

    Attributes:
        id: its area, a full stop, and its name.
        text: one sentence.
        clause: of the standard, or the section of docs/reference/wire.md or adapter-wire.md.
        level: its source: the standard (shall, should), the base wire, or an extension of it.
        covers: what of the catalog it is about: methods, notifications, types, messages of components.
        checks: what tries it from outside.
        tests: what tries it in the repository: pytest's node ids below `tests/`.
        gap: what is missing, or done otherwise, and why; empty where nothing is.
    """

    id: str
    text: str
    clause: str
    level: Level
    covers: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()
    gap: str = ""

    @property
    def is_checked(self) -> bool:
        """Whether any check or test covers it."""
        return bool(self.checks or self.tests)


@dataclass(frozen=True, slots=True)
class Area:
    """Requirements that belong together."""

    name: str
    title: str
    requirements: tuple[Requirement, ...]


_AREAS: Final = (
    "claim",
    "frame",
    "system",
    "command",
    "query",
    "event",
    "stream",
    "enum",
    "type",
    "runtime",
    "adapter",
    "extension",
    "signaling",
    "limit",
    "own",
)
_CATALOG_TESTS: Final = "openrois/catalog/test_basic.py::TestAgainstTheTable::test_"
_COMMON_TEST: Final = "openrois/catalog/test_basic.py::test_rois_common"


def read_manifest() -> tuple[Area, ...]:
    """Return the whole manifest; what the catalog says of components stands after the data types."""
    written = [_read(name) for name in _AREAS]
    position = _AREAS.index("type") + 1
    return (*written[:position], _components(), *written[position:])


def _read(area: str) -> Area:
    source = files("openrois_conformance").joinpath("requirements", f"{area}.toml")
    document = tomllib.loads(source.read_text(encoding="utf-8"))
    title = document.pop("title")
    return Area(area, title, tuple(_requirement(f"{area}.{name}", entry) for name, entry in document.items()))


def _requirement(requirement_id: str, entry: dict[str, Any]) -> Requirement:
    lists = {name: tuple(found) for name, found in entry.items() if isinstance(found, list)}
    return Requirement(**{**entry, **lists, "id": requirement_id, "level": Level(entry["level"])})


def _components() -> Area:
    """Return the requirements of clause 8.4: they follow from the catalog."""
    found = [requirement for kind in BASIC_COMPONENTS for requirement in _component(kind)]
    return Area("component", "Components: the seventeen types and RoIS_Common", (*_common(), *found))


def _common() -> Iterator[Requirement]:
    # Any type that includes the common messages shows whether they get through; this is the standard's second.
    checks = (check_of_type(BASIC_COMPONENTS[1]),)
    for kind, name, _ in _messages(ROIS_COMMON):
        text = f"Every type but SystemInformation has the {kind} `{name}`."
        yield _of(ROIS_COMMON, f".{name}", text, checks, (_COMMON_TEST,))


def _component(kind: ComponentType) -> Iterator[Requirement]:
    checks = (check_of_type(kind), "standard-profiles")
    yield _of(kind, "", kind.description, checks, (f"{_CATALOG_TESTS}names",))
    for what, name, description in _messages(kind):
        tests = {"query": "queries", "event": "events", "command": "commands"}[what]
        text = f"It has the {what} `{name}`: {description[0].lower()}{description[1:]}"
        yield _of(kind, f".{name}", text, checks, (f"{_CATALOG_TESTS}{tests}",))
    if kind.parameters is not None:
        names = ", ".join(f"`{name}`" for name in kind.parameters.model_fields)
        tests_of = (f"{_CATALOG_TESTS}parameters",)
        yield _of(kind, ".parameters", f"It has the parameters {names}.", checks, tests_of)


def _messages(kind: ComponentType) -> Iterator[tuple[str, str, str]]:
    """Yield the kind, name and description of every message of a type's own."""
    yield from (("command", command.name, command.description) for command in kind.commands)
    yield from (("query", query.name, query.description) for query in kind.queries)
    yield from (("event", event.name, event.description) for event in kind.events)


def check_of_type(kind: ComponentType) -> str:
    """Return the id of the check of a type of the standard."""
    return f"type-{kind.code.lower()}"


def _of(kind: ComponentType, suffix: str, text: str, checks: tuple[str, ...], tests: tuple[str, ...]) -> Requirement:
    name = f"{kind.code}{suffix}"
    return Requirement(f"component.{name}", text, f"8.4, {kind.code}", Level.SHALL, (name,), checks, tests)
