"""The generator's input: types, methods, notifications and components as plain data, free of Pydantic. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

__all__ = [
    "Component",
    "Definition",
    "Document",
    "Enumeration",
    "Field",
    "Identity",
    "Instant",
    "Integer",
    "ListOf",
    "MapOf",
    "Message",
    "Method",
    "Named",
    "Notification",
    "Number",
    "Structure",
    "Text",
    "Truth",
    "Type",
    "Union",
]


@dataclass(frozen=True, slots=True)
class Text:
    """Text, its length in characters."""

    min_length: int = 0
    max_length: int | None = None


@dataclass(frozen=True, slots=True)
class Integer:
    """A whole number."""

    minimum: int | None = None
    maximum: int | None = None


@dataclass(frozen=True, slots=True)
class Number:
    """A number that need not be whole. No message of the wire has one, only what is in a value's text."""


@dataclass(frozen=True, slots=True)
class Truth:
    """True or false."""


@dataclass(frozen=True, slots=True)
class Identity:
    """The id of a JSON-RPC request: text or a number, as its sender chose."""


@dataclass(frozen=True, slots=True)
class Instant:
    """A moment (DateTime). Only what is in a value's text has one."""


@dataclass(frozen=True, slots=True)
class ListOf:
    """A list."""

    item: "Type"
    min_items: int = 0
    max_items: int | None = None


@dataclass(frozen=True, slots=True)
class MapOf:
    """An object whose keys are any text."""

    item: "Type"


@dataclass(frozen=True, slots=True)
class Named:
    """A definition, by its name."""

    name: str


Type: TypeAlias = Text | Integer | Number | Truth | Identity | Instant | ListOf | MapOf | Named


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a structure.

    Attributes:
        name: on the wire.
        type: what it holds when it is not null.
        required: whether it always stands.
        nullable: whether it may be null.
        default: what its absence means, as JSON; None also where its absence has no meaning of its own.
        doc: a sentence, where there is one.
        code: of a value in a payload its `data_type_ref`; else empty.
        read_only: of a parameter, whether the component alone sets it.
    """

    name: str
    type: Type
    required: bool
    nullable: bool = False
    default: object = None
    doc: str = ""
    code: str = ""
    read_only: bool = False


@dataclass(frozen=True, slots=True)
class Enumeration:
    """Names, of which one stands on the wire."""

    name: str
    doc: str
    members: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Structure:
    """An object with these fields and no others."""

    name: str
    doc: str
    fields: tuple[Field, ...]


@dataclass(frozen=True, slots=True)
class Union:
    """One of several structures; each has a required field that no other one has."""

    name: str
    doc: str
    members: tuple[str, ...]


Definition: TypeAlias = Enumeration | Structure | Union


@dataclass(frozen=True, slots=True)
class Method:
    """A method that an application calls at an engine, and a gateway at its adapters.

    Attributes:
        name: on the wire.
        doc: one sentence.
        params, result: names of structures.
        extension: which one it belongs to; empty for the base.
        since: the version of RoIS, or of the extensions, that has it first.
    """

    name: str
    doc: str
    params: str
    result: str
    extension: str
    since: str


@dataclass(frozen=True, slots=True)
class Notification:
    """A notification of an engine to an application, and of an adapter to its gateway; attributes as of `Method`."""

    name: str
    doc: str
    params: str
    extension: str
    since: str


@dataclass(frozen=True, slots=True)
class Message:
    """A command, query or event of a component; what it takes and gives are names of payloads, empty for nothing."""

    name: str
    doc: str
    takes: str = ""
    gives: str = ""


@dataclass(frozen=True, slots=True)
class Component:
    """A component type; `includes` are names of others whose messages it has as well."""

    name: str
    urn: str
    doc: str
    function: str
    includes: tuple[str, ...]
    commands: tuple[Message, ...]
    queries: tuple[Message, ...]
    events: tuple[Message, ...]
    parameters: str


@dataclass(frozen=True, slots=True)
class Document:
    """Everything that files are generated from.

    Attributes:
        version: the date that the schema's folder is named after.
        definitions: the types of the wire by name, sorted.
        methods, notifications: the base first, each in the standard's order.
        components: the catalog's types, each after those that it includes.
        payloads: what the components' messages carry, in the catalog's order.
    """

    version: str
    definitions: Mapping[str, Definition]
    methods: tuple[Method, ...]
    notifications: tuple[Notification, ...]
    components: tuple[Component, ...]
    payloads: Mapping[str, Structure]
