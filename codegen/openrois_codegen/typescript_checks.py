"""TypeScript: checks of each incoming message, on top of the checks of `web_demo/sdk/rois/check.ts`."""

from collections.abc import Iterator
from typing import Final

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
    Structure,
    Text,
    Truth,
    Type,
    Union,
)

__all__ = ["emit"]

_SCALARS: Final[dict[type[Type], str]] = {
    Text: "text",
    Integer: "integer",
    Truth: "truth",
    Identity: "identity",
}


def emit(document: Document) -> str:
    """Return the module with a check of each result and notification; lengths and limits are not checked."""
    reached = _reached(document)
    enumerations = sorted(found.name for found in reached if isinstance(found, Enumeration))
    parts = [_definition(found) for found in reached]
    used = sorted({word for word in _CHECKS if any(_calls(word, part) for part in parts)})
    head = (
        "/** What is checked of each message that comes in. Written by `make generate`; edits are lost. */\n\n"
        f'import {{ {", ".join(used)} }} from "../check.ts";\n'
        'import type { Check } from "../check.ts";\n'
        'import type { MethodName, NotificationName } from "./methods.ts";\n'
        f'import {{ {", ".join(enumerations)} }} from "./types.ts";'
    )
    results = {method.name: method.result for method in document.methods}
    told = {notification.name: notification.params for notification in document.notifications}
    return (
        "\n\n".join(
            (
                head,
                *parts,
                _table("The result of each method.", "RESULTS", "MethodName", results),
                _table("The params of each notification.", "NOTIFICATIONS", "NotificationName", told),
            )
        )
        + "\n"
    )


_CHECKS: Final = (
    "identity",
    "integer",
    "itself",
    "list",
    "map",
    "object",
    "oneOf",
    "optional",
    "orNull",
    "text",
    "truth",
)


def _calls(word: str, part: str) -> bool:
    return any(f"{before}{word}{after}" in part for before in " (" for after in "(,) ;")


def _reached(document: Document) -> list[Definition]:
    """Return the definitions that results and notifications are made of, each after those that it needs."""
    found: dict[str, Definition] = {}

    def reach(name: str) -> None:
        if name in found:
            return
        definition = document.definitions[name]
        # A structure that holds itself is looked up when it is needed.
        for needed in _needs(definition):
            if needed != name:
                reach(needed)
        found[name] = definition

    for method in document.methods:
        reach(method.result)
    for notification in document.notifications:
        reach(notification.params)
    return list(found.values())


def _needs(definition: Definition) -> Iterator[str]:
    if isinstance(definition, Structure):
        for field in definition.fields:
            yield from _names(field.type)
    elif isinstance(definition, Union):
        raise TypeError(f"{definition.name}: nothing that comes in is one of several structures")


def _names(found: Type) -> Iterator[str]:
    if isinstance(found, Named):
        yield found.name
    elif isinstance(found, ListOf | MapOf):
        yield from _names(found.item)


def _definition(definition: Definition) -> str:
    if isinstance(definition, Enumeration):
        return f"const {_constant(definition.name)}: Check = oneOf({definition.name});"
    assert isinstance(definition, Structure)
    fields = "".join(f"  {field.name}: {_field(field, definition.name)},\n" for field in definition.fields)
    body = f"{{\n{fields}}}" if fields else "{}"
    return f"const {_constant(definition.name)}: Check = object({body});"


def _field(field: Field, inside: str) -> str:
    check = _check(field.type, inside)
    if field.nullable:
        check = f"orNull({check})"
    return check if field.required else f"optional({check})"


def _check(found: Type, inside: str) -> str:
    if isinstance(found, ListOf):
        return f"list({_check(found.item, inside)})"
    if isinstance(found, MapOf):
        return f"map({_check(found.item, inside)})"
    if isinstance(found, Named):
        if found.name == inside:
            return f"itself(() => {_constant(inside)})"
        return _constant(found.name)
    return _SCALARS[type(found)]


def _table(doc: str, name: str, keys: str, types: dict[str, str]) -> str:
    lines = "".join(f'  "{method}": {_constant(structure)},\n' for method, structure in types.items())
    return f"/** {doc} */\nexport const {name}: {{ readonly [Name in {keys}]: Check }} = {{\n{lines}}};"


def _constant(name: str) -> str:
    return f"is{name}"
