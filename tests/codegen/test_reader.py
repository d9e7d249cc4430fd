"""Reading models: names, types, limits, what may be absent or null, and what no wire has."""

from collections.abc import Iterator
from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any, Literal

import pytest
from openrois_codegen.ir import (
    Enumeration,
    Field,
    Identity,
    Instant,
    Integer,
    ListOf,
    MapOf,
    Named,
    Number,
    Structure,
    Text,
    Truth,
    Union,
)
from openrois_codegen.reader import Reader
from pydantic import BaseModel, ConfigDict, create_model
from pydantic import Field as Declared

from openrois.catalog.payload import Data, Payload


class Colour(StrEnum):
    """What colour it has."""

    RED = "red"
    BLUE = "blue"


class Leaf(BaseModel):
    """A leaf.

    It hangs on a tree.
    """

    colour: Colour = Colour.RED


class Branch(BaseModel):
    """A branch."""

    parts: tuple["Part", ...] = ()


Part = Leaf | Branch
Branch.model_rebuild()
Side = Literal["left", "right"]


def fields(reader: Reader, **declared: Any) -> Iterator[Field]:
    """Read a model with these fields and yield them."""
    found = reader.definitions[reader.read(create_model("Made", **declared))]
    assert isinstance(found, Structure)
    return iter(found.fields)


@pytest.mark.parametrize(
    ("annotation", "found"),
    [
        (str, Text()),
        (int, Integer()),
        (bool, Truth()),
        (float, Number()),
        (str | int | float, Identity()),
        (datetime, Instant()),
        (Annotated[str, Declared(min_length=1, max_length=9)], Text(1, 9)),
        (Annotated[str, Declared(min_length=1, json_schema_extra={"maxLength": 9})], Text(1, 9)),
        (Annotated[int, Declared(ge=0, le=7)], Integer(0, 7)),
        (Annotated[int, Declared(gt=0, lt=7)], Integer(1, 6)),
        (tuple[int, ...], ListOf(Integer())),
        (Annotated[tuple[str, ...], Declared(max_length=4, json_schema_extra={"minItems": 1})], ListOf(Text(), 1, 4)),
        (tuple[Annotated[int, Declared(ge=0)], ...], ListOf(Integer(0))),
        (dict[str, tuple[bool, ...]], MapOf(ListOf(Truth()))),
        (Colour, Named("Colour")),
        (Leaf, Named("Leaf")),
        (Side, Named("Side")),
        (tuple[Part, ...], ListOf(Named("Part"))),
    ],
)
def test_types(annotation: Any, found: object) -> None:
    names = {Side: ("Side", "Which side."), Part: ("Part", "A part of a tree.")}
    assert [field.type for field in fields(Reader(names), it=(annotation, ...))] == [found]


def test_definitions() -> None:
    reader = Reader({Side: ("Side", "Which side."), Part: ("Part", "A part of a tree.")})
    next(fields(reader, tree=(Branch, ...), side=(Side, ...)))
    assert reader.definitions["Colour"] == Enumeration("Colour", "What colour it has.", ("red", "blue"))
    assert reader.definitions["Side"] == Enumeration("Side", "Which side.", ("left", "right"))
    assert reader.definitions["Part"] == Union("Part", "A part of a tree.", ("Leaf", "Branch"))
    assert reader.definitions["Branch"] == Structure(
        "Branch", "A branch.", (Field("parts", ListOf(Named("Part")), required=False, default=[]),)
    )
    leaf = reader.definitions["Leaf"]
    assert isinstance(leaf, Structure)
    assert leaf.doc == "A leaf.\n\nIt hangs on a tree."
    assert leaf.fields == (Field("colour", Named("Colour"), required=False, default="red"),)
    assert set(reader.enumerations()) == {"Colour", "Side"}
    assert (reader.sources["Leaf"], reader.sources["Part"], reader.sources["Side"]) == (Leaf, Part, Side)


def test_what_may_be_absent_or_null() -> None:
    required, absent, null, both = fields(
        Reader({}), a=(int, ...), b=(int, 5), c=(Annotated[int, Declared(le=9)] | None, ...), d=(int | None, None)
    )
    assert (required.required, required.nullable, required.default) == (True, False, None)
    assert (absent.required, absent.nullable, absent.default) == (False, False, 5)
    assert (null.required, null.nullable, null.type) == (True, True, Integer(maximum=9))
    assert (both.required, both.nullable, both.default) == (False, True, None)


def test_what_has_a_default_may_be_required_on_the_wire() -> None:
    class Answer(BaseModel):
        model_config = ConfigDict(json_schema_extra={"required": ["code"]})
        code: str = "OK"
        more: str = ""

    reader = Reader({})
    reader.read(Answer)
    found = reader.definitions["Answer"]
    assert isinstance(found, Structure)
    assert [field.required for field in found.fields] == [True, False]


def test_what_is_said_of_a_payload() -> None:
    class Seen(Payload):
        number: Annotated[int, Data("long", "M", "how many")]
        since: datetime

    reader = Reader({})
    reader.read(Seen)
    found = reader.definitions["Seen"]
    assert isinstance(found, Structure)
    assert [(field.code, field.doc) for field in found.fields] == [("long", "how many"), ("DateTime", "")]


@pytest.mark.parametrize("annotation", [bytes, set[str], tuple[int, str], dict[int, str], int | str | None, object])
def test_what_no_wire_has(annotation: Any) -> None:
    with pytest.raises(TypeError):
        next(fields(Reader({}), it=(annotation, ...)))


@pytest.mark.parametrize("annotation", [Annotated[str, Declared(pattern="x")], Annotated[int, Declared(multiple_of=2)]])
def test_a_limit_that_nothing_is_made_of_is_not_passed_over(annotation: Any) -> None:
    with pytest.raises(TypeError, match="nothing is generated from"):
        next(fields(Reader({}), it=(annotation, ...)))
