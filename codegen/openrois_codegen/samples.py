"""Values of each type, and values just outside of it: beyond its limits, of another type, with a null. Pure."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any, Final

from openrois_codegen.ir import (
    Document,
    Enumeration,
    Field,
    Identity,
    Integer,
    ListOf,
    MapOf,
    Named,
    Structure,
    Text,
    Type,
    Union,
)

__all__ = ["Bad", "Samples"]

_LIMIT: Final = 1024
"""Text that is longer only makes the corpus long."""

_TEXTS: Final = {
    "plain": "robot/navigation",
    "one character": "x",
    "Japanese": "こんにちは、ロボット",
    "right to left": "שלום",
    "emoji": "👩‍🚀🤖",
    "quotes and escapes": "\"'\\/\b\f\n\r\t",
    "a control character": "\u0001",
    "spaces": "  x  ",
    "like a number": "1",
    "like true": "true",
    "like null": "null",
    "like a date": "2026-11-21T12:00:00.000001+09:00",
    "like an object": '{"a":[1]}',
}
_WHOLE: Final = {"0": 0, "1": 1, "-1": -1, "2**31-1": 2**31 - 1, "-2**31": -(2**31), "2**53-1": 2**53 - 1}

_COMPANIONS: Final[Mapping[tuple[str, str], Mapping[str, Any]]] = {
    ("Candidate", "candidate"): {"sdp_mid": "0"},
}
"""Fields that have to stand beside a field, although the type alone does not say so."""


@dataclass(frozen=True, slots=True)
class Bad:
    """A value that does not fit, its peculiarity, and the kind of its fault."""

    name: str
    value: Any
    kind: str


class Samples:
    """Values of the types of a document."""

    def __init__(self, document: Document) -> None:
        self.version = document.version
        self._definitions = document.definitions

    def companions(self, structure: str, field: str) -> Mapping[str, Any]:
        """Return what has to stand beside a field, apart from what is required."""
        return _COMPANIONS.get((structure, field), {})

    def least(self, name: str) -> dict[str, Any]:
        """Return an object with nothing but what is required, null where it may be."""
        required = [field for field in self._structure(name).fields if field.required]
        return {field.name: None if field.nullable else self._first(field.type) for field in required}

    def full(self, name: str) -> dict[str, Any]:
        """Return an object with every field; what is in them has what is required."""
        return {field.name: self._some(field.type) for field in self._structure(name).fields}

    def _structure(self, name: str) -> Structure:
        found = self._definitions[name]
        assert isinstance(found, Structure), f"{name} is no structure"
        return found

    def _first(self, kind: Type) -> Any:
        return next(self.good(kind))[1]

    def _some(self, kind: Type) -> Any:
        """Return a value that is not empty."""
        if isinstance(kind, ListOf):
            return [self._some(kind.item)]
        if isinstance(kind, MapOf):
            return {"key": self._some(kind.item)}
        return self._first(kind)

    def good(self, kind: Type) -> Iterator[tuple[str, Any]]:
        """Yield values that fit, each with what is special about it."""
        if isinstance(kind, Text):
            yield from _texts(kind)
        elif isinstance(kind, Integer):
            yield from ((name, value) for name, value in _integers(kind).items() if _fits(kind, value))
        elif isinstance(kind, Identity):
            yield from (("text", "request"), ("empty", ""), ("0", 0), ("-1", -1), ("2**53-1", 2**53 - 1), ("1.5", 1.5))
        elif isinstance(kind, ListOf):
            yield from self._lists(kind)
        elif isinstance(kind, MapOf):
            item = self._first(kind.item)
            yield from (
                ("empty", {}),
                ("one", {"key": item}),
                ("keys of any text", {"": item, "鍵": item, "🗝️/a.b": item}),
            )
        else:
            assert isinstance(kind, Named)
            yield from self._named(kind.name)

    def _lists(self, kind: ListOf) -> Iterator[tuple[str, Any]]:
        item = self._first(kind.item)
        for name, count in (("one", 1), ("empty", 0), ("two", 2), ("most", kind.max_items or 3)):
            if kind.min_items <= count:
                yield name, [item] * count
        yield "each kind", [value for _, value in self.good(kind.item)][: kind.max_items]

    def _named(self, name: str) -> Iterator[tuple[str, Any]]:
        found = self._definitions[name]
        if isinstance(found, Enumeration):
            yield from ((member, member) for member in found.members)
        elif isinstance(found, Union):
            yield from ((member, self.least(member)) for member in found.members)
        else:
            yield "the least", self.least(name)
            yield "all fields", self.full(name)

    def bad(self, kind: Type) -> Iterator[Bad]:
        """Yield values that do not fit, null not among them."""
        if isinstance(kind, Text):
            yield from _others("a text", 1, 1.5, True, [], {}, ["x"])
            yield from _badly_long(kind)
        elif isinstance(kind, Integer):
            yield from _others("a number", "1", "", 1.5, True, [], {})
            yield from _out_of_range(kind)
        elif isinstance(kind, Identity):
            yield from _others("an id", True, [], {}, ["x"])
        elif isinstance(kind, ListOf):
            yield from _others("a list", "x", "", 1, True, {})
            yield from self._bad_lists(kind)
        elif isinstance(kind, MapOf):
            yield from _others("an object", "x", 1, True, [])
            yield Bad("null in it", {"key": None}, "null")
            yield from (Bad(f"in it {bad.name}", {"key": bad.value}, bad.kind) for bad in self._once(kind.item))
        else:
            assert isinstance(kind, Named)
            yield from self._bad_named(kind.name)

    def _bad_lists(self, kind: ListOf) -> Iterator[Bad]:
        item = self._first(kind.item)
        if kind.min_items:
            yield Bad("too few", [item] * (kind.min_items - 1), "range")
        if kind.max_items is not None:
            yield Bad("too many", [item] * (kind.max_items + 1), "range")
        yield Bad("null in it", [None], "null")
        yield Bad("null at its end", [item, None], "null")
        yield from (Bad(f"in it {bad.name}", [bad.value], bad.kind) for bad in self._once(kind.item))

    def _bad_named(self, name: str) -> Iterator[Bad]:
        found = self._definitions[name]
        if isinstance(found, Enumeration):
            yield from self.bad_enumeration(found)
        else:
            yield from self.no_objects()
            yield from self._once(Named(name))

    def _once(self, kind: Type) -> Iterator[Bad]:
        """Yield one value for each kind of fault: the type of it has them all."""
        kinds: set[str] = set()
        for bad in self._all_bad(kind):
            if bad.kind not in kinds:
                kinds.add(bad.kind)
                yield bad

    def _all_bad(self, kind: Type) -> Iterator[Bad]:
        found = self._definitions[kind.name] if isinstance(kind, Named) else None
        if isinstance(found, Union):
            found = self._definitions[found.members[0]]
        if not isinstance(found, Structure):
            yield from self.bad(kind)
            return
        least = self.least(found.name)
        yield Bad("an unknown field", {**least, "unknown": 1}, "unknown")
        yield Bad("no object", "x", "type")
        for field in found.fields:
            yield from self._bad_field(field, least)

    def _bad_field(self, field: Field, least: Mapping[str, Any]) -> Iterator[Bad]:
        if field.required:
            yield Bad(f"no {field.name}", {k: v for k, v in least.items() if k != field.name}, "missing")
        if not field.nullable:
            yield Bad(f"null {field.name}", {**least, field.name: None}, "null")
        if isinstance(field.type, Text | Integer):
            bad = next(self.bad(field.type))
            yield Bad(f"{field.name} {bad.name}", {**least, field.name: bad.value}, bad.kind)

    def bad_enumeration(self, found: Enumeration) -> Iterator[Bad]:
        """Yield what is no member."""
        member = found.members[0]
        for name in ("", member.swapcase(), f" {member}", f"{member}x", "0"):
            yield Bad(f"the name {name!r}", name, "name")
        yield from _others("a name", 0, True, [], {}, [member])

    def no_objects(self) -> Iterator[Bad]:
        """Yield what is no object and not null."""
        yield from _others("an object", "x", 1, True, [], [{}])

    def at_random(self, name: str, chance: Random, depth: int = 3) -> Any:
        """Return a value of a type, made by chance, with objects at most `depth` deep in it."""
        found = self._definitions[name]
        if isinstance(found, Enumeration):
            return chance.choice(found.members)
        if isinstance(found, Union):
            return self.at_random(chance.choice(found.members), chance, depth)
        made: dict[str, Any] = {}
        for field in found.fields:
            if field.required or (depth and chance.random() < 0.6):
                null = field.nullable and chance.random() < 0.3
                made[field.name] = None if null else self._random(field.type, chance, depth)
        for field_name in tuple(made):
            made.update(self.companions(name, field_name))
        return made

    def _random(self, kind: Type, chance: Random, depth: int) -> Any:
        if isinstance(kind, Named):
            return self.at_random(kind.name, chance, max(depth - 1, 0))
        if isinstance(kind, ListOf):
            count = max(kind.min_items, chance.randrange(3) if depth else 0)
            return [self._random(kind.item, chance, depth) for _ in range(count)]
        if isinstance(kind, MapOf):
            return {key: self._random(kind.item, chance, depth) for key in ("a/1", "b/2")[: chance.randrange(3)]}
        return chance.choice([value for name, value in self.good(kind) if name != "most"])

    def spoilt_at_random(self, name: str, chance: Random) -> tuple[Any, Bad] | None:
        """Return a value made by chance with one fault somewhere in it, or None for a type that has no fields."""
        found = self._definitions[name]
        if isinstance(found, Union):
            return self.spoilt_at_random(chance.choice(found.members), chance)
        if not isinstance(found, Structure) or not found.fields:
            return None
        field = chance.choice(found.fields)
        bad = chance.choice(
            [bad for bad in (*self.bad(field.type), *self._all_bad(field.type)) if bad.name != "too many"]
        )
        return {**self.at_random(name, chance), field.name: bad.value}, Bad(
            f"{field.name}: {bad.name}", bad.value, bad.kind
        )


def _texts(kind: Text) -> Iterator[tuple[str, str]]:
    for name, text in _TEXTS.items():
        if kind.max_length is None or len(text) <= kind.max_length:
            yield name, text
    if not kind.min_length:
        yield "empty", ""
    if kind.max_length is not None and kind.max_length <= _LIMIT:
        yield "most", "x" * kind.max_length


def _badly_long(kind: Text) -> Iterator[Bad]:
    if kind.min_length:
        yield Bad("too short", "x" * (kind.min_length - 1), "range")
    if kind.max_length is not None and kind.max_length <= _LIMIT:
        yield Bad("too long", "x" * (kind.max_length + 1), "range")


def _integers(kind: Integer) -> dict[str, int]:
    edges = {"least": kind.minimum, "most": kind.maximum}
    return {**_WHOLE, **{name: limit for name, limit in edges.items() if limit is not None}}


def _fits(kind: Integer, value: int) -> bool:
    return (kind.minimum is None or kind.minimum <= value) and (kind.maximum is None or value <= kind.maximum)


def _out_of_range(kind: Integer) -> Iterator[Bad]:
    if kind.minimum is not None:
        yield Bad("too small", kind.minimum - 1, "range")
    if kind.maximum is not None:
        yield Bad("too great", kind.maximum + 1, "range")


def _others(wanted: str, *values: Any) -> Iterator[Bad]:
    yield from (Bad(f"{json.dumps(value)} for {wanted}", value, "type") for value in values)
