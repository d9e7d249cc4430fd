"""TypeScript: the wire's types, the methods by name, and a typed proxy for each component; as prettier formats it.

Pure.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from openrois_codegen.ir import (
    Component,
    Definition,
    Document,
    Enumeration,
    Field,
    Identity,
    Instant,
    Integer,
    ListOf,
    MapOf,
    Message,
    Named,
    Number,
    Structure,
    Text,
    Truth,
    Type,
    Union,
)
from openrois_codegen.names import camel, constant, first_paragraph, wrapped

__all__ = ["components", "methods", "types"]

_WIDTH: Final = 110
_SCALARS: Final[dict[type[Type], str]] = {
    Text: "string",
    Integer: "number",
    Number: "number",
    Truth: "boolean",
    Identity: "string | number",
    Instant: "Date",
}


def types(document: Document) -> str:
    """Return the module of the wire's types."""
    return _module(
        "Types of the wire, named as in the data model.",
        *(_definition(found) for found in document.definitions.values()),
    )


def methods(document: Document) -> str:
    """Return the module of what each method and notification carries."""
    names = {name for method in document.methods for name in (method.params, method.result)}
    names |= {notification.params for notification in document.notifications}
    requests = [
        f"readonly {_quoted(method.name)}: {{ params: {method.params}; result: {method.result} }};"
        for method in document.methods
    ]
    told = [f"readonly {_quoted(found.name)}: {found.params};" for found in document.notifications]
    method_docs = [method.doc for method in document.methods]
    return _module(
        "What each method and notification of the wire carries.",
        _import(sorted(names), "./types.ts", type_only=True),
        _interface("Methods", "Params and result of every method that an application may call.", requests, method_docs),
        "export type MethodName = keyof Methods;",
        _interface(
            "Notifications",
            "Params of every notification that an application may get.",
            told,
            [notification.doc for notification in document.notifications],
        ),
        "export type NotificationName = keyof Notifications;",
    )


def components(document: Document) -> str:
    """Return the module of component proxies: a payload's type stands before the first class that needs it."""
    included = {name for component in document.components for name in component.includes}
    parameters = {component.parameters for component in document.components}
    parts: list[str] = []
    written: set[str] = set()
    for component in document.components:
        for name in _payloads(component):
            if name not in written:
                written.add(name)
                parts.append(_payload(document.payloads[name], parameters=name in parameters))
        parts.append(_proxy(document, component, generic=component.name in included))
    enumerations = sorted({name for payload in document.payloads.values() for name in _named(payload)})
    return _module(
        "The component types of the catalog: what their messages carry, and a proxy for each.",
        "\n".join(
            (
                _import(["ComponentProxy", "encode"], "../component.ts"),
                _import(["Types"], "../component.ts", type_only=True),
                _import(enumerations, "./types.ts", type_only=True),
            )
        ),
        *parts,
    )


def _module(doc: str, *parts: str) -> str:
    head = f"/** {doc} Written by `make generate`; edits are lost. */"
    return "\n\n".join((head, *parts)) + "\n"


def _definition(found: Definition) -> str:
    if isinstance(found, Enumeration):
        members = _group("[", [_quoted(member) for member in found.members], "]", f"export const {found.name} = ", 9)
        return (
            f"{_doc(found.doc)}export const {found.name} = {members} as const;\n"
            f"export type {found.name} = (typeof {found.name})[number];"
        )
    if isinstance(found, Union):
        return f"{_doc(found.doc)}export type {found.name} = {' | '.join(found.members)};"
    if not found.fields:
        return f"{_doc(found.doc)}export type {found.name} = {{ readonly [name: string]: never }};"
    return _interface(
        found.name,
        found.doc,
        [_property(field, optional=not field.required) for field in found.fields],
        [field.doc for field in found.fields],
    )


def _property(field: Field, *, optional: bool, nullable: bool = True) -> str:
    null = " | null" if field.nullable and nullable else ""
    return f"readonly {field.name}{'?' if optional else ''}: {_type(field.type)}{null};"


def _type(found: Type) -> str:
    if isinstance(found, Named):
        return found.name
    if isinstance(found, ListOf):
        return f"readonly {_type(found.item)}[]"
    if isinstance(found, MapOf):
        return f"{{ readonly [name: string]: {_type(found.item)} }}"
    return _SCALARS[type(found)]


def _interface(name: str, doc: str, members: Sequence[str], docs: Sequence[str]) -> str:
    lines = "".join(f"{_doc(text, 2)}  {member}\n" for member, text in zip(members, docs, strict=True))
    return f"{_doc(doc)}export interface {name} {{\n{lines}}}"


def _payload(payload: Structure, *, parameters: bool) -> str:
    """Return the interface of a payload and the codes of its values; parameters are all optional."""
    interface = _interface(
        payload.name,
        payload.doc,
        [_property(field, optional=parameters or not field.required, nullable=False) for field in payload.fields],
        [field.doc for field in payload.fields],
    )
    codes = [
        f"{field.name}: {_quoted(field.code + ('' if parameters or field.required else '?'))}"
        for field in payload.fields
    ]
    head = f"const {constant(payload.name)}: Types<{payload.name}> = "
    return f"{interface}\n{head}{_group('{ ', codes, ' }', head, 1)};"


def _proxy(document: Document, component: Component, *, generic: bool) -> str:
    (base,) = component.includes or ("ComponentProxy",)
    name = component.name
    if generic:
        name += "<\n  Parameters extends object = object,\n  ReadOnly extends keyof Parameters = never,\n>"
        base += "<Parameters, ReadOnly>"
    elif component.parameters:
        fields = document.payloads[component.parameters].fields
        read_only = " | ".join(_quoted(field.name) for field in fields if field.read_only)
        arguments = [component.parameters, *([read_only] if read_only else [])]
        base += f"<{', '.join(arguments)}>"
        if len(f"export class {name} extends {base} {{") > _WIDTH:
            # prettier has no comma after the last of them.
            base = base.replace("<", "<\n  ").replace(", ", ",\n  ").replace(">", "\n>")
    members = list(_members(component, typed=not generic))
    body = "".join("\n" * (index > 0) + member for index, member in enumerate(members))
    return f"{_doc(component.doc)}export class {name} extends {base} {{\n{body}}}"


def _members(component: Component, *, typed: bool) -> Iterator[str]:
    fields = f"  static readonly componentType = {_quoted(component.urn)};\n" if typed else ""
    if component.parameters:
        fields += f"  protected override readonly parameterTypes = {constant(component.parameters)};\n"
    if fields:
        yield fields
    yield from (_command(command) for command in component.commands)
    yield from (_query(query) for query in component.queries)
    for event in component.events:
        heard = f"this.event({_quoted(event.name)}, {constant(event.gives)})"
        yield f"{_doc(event.doc, 2)}  readonly {camel(event.name)} = {heard};\n"


def _command(command: Message) -> str:
    takes = f"values: {command.takes}" if command.takes else ""
    values = [f"encode({constant(command.takes)}, values)"] if command.takes else []
    verb, given = ("obtain", [constant(command.gives)]) if command.gives else ("execute", [])
    arguments = ", ".join([_quoted(command.name), *given, *values])
    return _method(command, takes, f"this.{verb}({arguments})")


def _query(query: Message) -> str:
    asked = f"this.query({_quoted(query.name)}, {constant(query.gives)}, condition)"
    return _method(query, "condition?: string", asked)


def _method(message: Message, takes: str, expression: str) -> str:
    head = f"  {camel(message.name)}({takes}): Promise<{message.gives or 'void'}> {{"
    return f"{_doc(message.doc, 2)}{head}\n    return {expression};\n  }}\n"


def _payloads(component: Component) -> Iterator[str]:
    messages = (*component.commands, *component.queries, *component.events)
    found = (*(name for message in messages for name in (message.takes, message.gives)), component.parameters)
    yield from (name for name in found if name)


def _named(payload: Structure) -> Iterator[str]:
    yield from (field.type.name for field in payload.fields if isinstance(field.type, Named))


def _import(names: Sequence[str], module: str, *, type_only: bool = False) -> str:
    head = "import type " if type_only else "import "
    source = f" from {_quoted(module)};"
    return f"{head}{_group('{ ', names, ' }', head, len(source))}{source}"


def _group(opening: str, items: Sequence[str], closing: str, head: str, tail: int) -> str:
    """Return items on one line where they fit between a head and a tail of that many characters, else one on each."""
    line = f"{opening}{', '.join(items)}{closing}"
    if len(head) + len(line) + tail <= _WIDTH:
        return line
    return "\n".join((opening.rstrip(), *(f"  {item}," for item in items), closing.lstrip()))


def _doc(text: str, indent: int = 0) -> str:
    """Return a comment of the first paragraph and a line break, or nothing."""
    text = first_paragraph(text)
    if not text:
        return ""
    space = " " * indent
    if len(text) + indent + 7 <= _WIDTH:
        return f"{space}/** {text} */\n"
    return "".join((f"{space}/**\n", *(f"{space} * {line}\n" for line in wrapped(text, 100 - indent)), f"{space} */\n"))


def _quoted(text: str) -> str:
    return f'"{text}"'
