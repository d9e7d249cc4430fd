"""A corpus of messages, valid and invalid by construction, that the tests of every language read. Pure.

Each type has a file. Its own fields are gone through one by one; what stands in them has a file of its own, and is here
only once right and once wrong. Random messages, always the same ones, go deeper.
"""

import json
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois_codegen.ir import Document, Enumeration, Field, Structure, Union
from openrois_codegen.samples import Bad, Samples

__all__ = ["Case", "cases", "emit"]

_RANDOM: Final = 5


@dataclass(frozen=True, slots=True)
class Case:
    """A message.

    Attributes:
        name: what is special about it.
        message: as JSON.
        kind: what is wrong with it: `missing`, `unknown`, `null`, `type`, `name`, `range`, or `rule` for what no schema
            says; empty where it is valid.
    """

    name: str
    message: Any
    kind: str = ""


def emit(document: Document, by_hand: Mapping[str, tuple[Case, ...]]) -> dict[str, str]:
    """Return the text of each file by its name.

    Args:
        document: the types.
        by_hand: further cases, by the type that they are of.
    """
    return {
        f"{name}.json": _written(name, [*cases(document, name), *by_hand.get(name, ())])
        for name in document.definitions
    }


def cases(document: Document, name: str) -> Iterator[Case]:
    """Yield the cases of a type."""
    samples = Samples(document)
    found = document.definitions[name]
    if isinstance(found, Enumeration):
        yield from (Case(member, member) for member in found.members)
        yield from (Case(bad.name, bad.value, bad.kind) for bad in samples.bad_enumeration(found))
        return
    yield from (Case(bad.name, bad.value, "type") for bad in samples.no_objects())
    if isinstance(found, Union):
        yield from _of_union(samples, found)
    else:
        yield from _of_structure(samples, found)
    yield from _at_random(samples, name)


def _of_union(samples: Samples, union: Union) -> Iterator[Case]:
    for member in union.members:
        yield Case(f"{member}: the least", samples.least(member))
        yield Case(f"{member}: all fields", samples.full(member))
        yield Case(f"{member}: an unknown field", {**samples.least(member), "unknown": 1}, "unknown")
    merged = {name: value for member in union.members for name, value in samples.least(member).items()}
    yield Case("fields of all at once", merged, "unknown")
    yield Case("fields of none", {}, "missing")


def _of_structure(samples: Samples, structure: Structure) -> Iterator[Case]:
    least = samples.least(structure.name)
    yield Case("the least", least)
    yield Case("all fields", samples.full(structure.name))
    for name, unknown in (("unknown", 1), ("unknown", None), ("", "")):
        yield Case(f"unknown field {name!r}: {json.dumps(unknown)}", {**least, name: unknown}, "unknown")
    for field in structure.fields:
        yield from _of_field(samples, structure, field, least)


def _of_field(samples: Samples, structure: Structure, field: Field, least: Mapping[str, Any]) -> Iterator[Case]:
    def having(value: object) -> dict[str, Any]:
        return {**least, **samples.companions(structure.name, field.name), field.name: value}

    if field.required:
        yield Case(f"{field.name}: absent", {k: v for k, v in least.items() if k != field.name}, "missing")
    yield Case(f"{field.name}: null", having(None), "" if field.nullable else "null")
    for name, value in samples.good(field.type):
        yield Case(f"{field.name}: {name}", having(value))
    for bad in samples.bad(field.type):
        yield Case(f"{field.name}: {bad.name}", having(bad.value), bad.kind)


def _at_random(samples: Samples, name: str) -> Iterator[Case]:
    chance = random.Random(f"{samples.version} {name}")  # noqa: S311 - the same ones every time are what is wanted
    for number in range(_RANDOM):
        yield Case(f"random {number}", samples.at_random(name, chance))
    for number in range(_RANDOM):
        found: tuple[Any, Bad] | None = samples.spoilt_at_random(name, chance)
        if found is not None:
            message, bad = found
            yield Case(f"random {number}: {bad.name}", message, bad.kind)


def _written(name: str, found: list[Case]) -> str:
    """Return a file's text: one case on each line."""
    valid = [_line({"name": case.name, "message": case.message}) for case in found if not case.kind]
    invalid = [_line({"name": case.name, "kind": case.kind, "message": case.message}) for case in found if case.kind]
    return f'{{"type": "{name}",\n"valid": [\n{_joined(valid)}],\n"invalid": [\n{_joined(invalid)}]}}\n'


def _line(case: Mapping[str, Any]) -> str:
    return json.dumps(case, ensure_ascii=False, separators=(",", ":"))


def _joined(lines: list[str]) -> str:
    return "".join(f"{line}{',' * (number < len(lines))}\n" for number, line in enumerate(lines, 1))
