"""JSON Schema (2020-12): every type of the wire under `$defs`, in one document. Pure."""

import json
from collections.abc import Mapping
from typing import Any, Final

from openrois_codegen.ir import (
    Definition,
    Document,
    Enumeration,
    Field,
    Identity,
    Integer,
    ListOf,
    MapOf,
    Named,
    Text,
    Type,
    Union,
)

__all__ = ["DIALECT", "emit", "field_schema", "schemas", "written"]

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"

Schema = dict[str, Any]


def emit(document: Document) -> str:
    """Return the schema document."""
    return written(
        {
            "$schema": DIALECT,
            "$id": f"urn:x-openrois:schema:{document.version}",
            "title": "Messages of RoIS 2.0 over JSON-RPC",
            "$defs": schemas(document, "#/$defs/"),
        }
    )


def schemas(document: Document, place: str) -> dict[str, Schema]:
    """Return the schema of every definition by name; references begin with `place`."""
    return {name: _definition(found, place) for name, found in document.definitions.items()}


def field_schema(field: Field, place: str) -> Schema:
    """Return the schema of a field's value."""
    found = _type(field.type, place)
    if field.nullable:
        found = {"anyOf": [found, {"type": "null"}]} if "$ref" in found else {**found, "type": _or_null(found["type"])}
    if not field.required:
        found["default"] = field.default
    return found


def written(found: Mapping[str, Any]) -> str:
    """Return a document as text: sorted, two spaces, a line break at its end."""
    return json.dumps(found, indent=2, sort_keys=True, ensure_ascii=False) + "\n"


def _definition(found: Definition, place: str) -> Schema:
    about = {"title": found.name, "description": found.doc}
    if isinstance(found, Enumeration):
        return {**about, "type": "string", "enum": list(found.members)}
    if isinstance(found, Union):
        return {**about, "oneOf": [{"$ref": place + member} for member in found.members]}
    required = [field.name for field in found.fields if field.required]
    return {
        **about,
        "type": "object",
        "properties": {field.name: field_schema(field, place) for field in found.fields},
        **({"required": required} if required else {}),
        "additionalProperties": False,
    }


def _type(found: Type, place: str) -> Schema:
    if isinstance(found, Named):
        return {"$ref": place + found.name}
    if isinstance(found, ListOf):
        limits = {"minItems": found.min_items or None, "maxItems": found.max_items}
        return {"type": "array", "items": _type(found.item, place), **_present(limits)}
    if isinstance(found, MapOf):
        return {"type": "object", "additionalProperties": _type(found.item, place)}
    if isinstance(found, Text):
        return {"type": "string", **_present({"minLength": found.min_length or None, "maxLength": found.max_length})}
    if isinstance(found, Integer):
        return {"type": "integer", **_present({"minimum": found.minimum, "maximum": found.maximum})}
    if isinstance(found, Identity):
        return {"type": ["string", "number"]}
    raise TypeError(f"{found} stands in the text of a value, never in a message")


def _or_null(kinds: str | list[str]) -> list[str]:
    return [*([kinds] if isinstance(kinds, str) else kinds), "null"]


def _present(keywords: Mapping[str, int | None]) -> dict[str, int]:
    return {keyword: limit for keyword, limit in keywords.items() if limit is not None}
