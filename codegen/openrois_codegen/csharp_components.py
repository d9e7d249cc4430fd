"""C#: the payloads of the catalog's messages, and a proxy class for each component; C# 6 for Unity.

Pure.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from openrois_codegen.csharp_source import block, documented, source_file
from openrois_codegen.ir import (
    Component,
    Document,
    Field,
    Instant,
    Integer,
    ListOf,
    Message,
    Named,
    Number,
    Structure,
    Text,
    Truth,
    Type,
)
from openrois_codegen.names import camel, pascal

__all__ = ["components", "payloads"]

_SCALARS: Final[Mapping[type[Type], str]] = {
    Text: "string",
    Integer: "long",
    Number: "double",
    Truth: "bool",
    Instant: "DateTimeOffset",
}
_STREAMS: Final = "connect_stream"
"""A component with this command has its streaming verbs from a class that is written by hand."""

_TOKEN: Final = "CancellationToken token = default(CancellationToken)"  # noqa: S105


def payloads(document: Document) -> str:
    """Return the file of what the components' messages carry."""
    parameters = {component.parameters for component in document.components}
    by_hand = {
        name
        for component in document.components
        if _has_streams(component)
        for message in (*component.commands, *component.queries, *component.events)
        for name in (message.takes, message.gives)
    }
    given = {
        name: payload
        for name, payload in document.payloads.items()
        if name not in by_hand and (name in parameters or _has_class(document, name))
    }
    return source_file(
        "OpenRoIS.Components",
        "What the messages of the catalog's components carry.",
        [_payload(payload, partial=name in parameters) for name, payload in given.items()],
        "System",
        "System.Collections.Generic",
    )


def components(document: Document) -> str:
    """Return the file of component proxies."""
    known = {component.name: component for component in document.components}
    return source_file(
        "OpenRoIS.Components",
        "The component types of the catalog, as an application sees them.",
        [_component(document, component, known) for component in document.components],
        "System.Collections.Generic",
        "System.Threading",
        "System.Threading.Tasks",
    )


def _has_streams(component: Component) -> bool:
    return any(command.name == _STREAMS for command in component.commands)


def _has_class(document: Document, name: str) -> bool:
    """Tell whether a payload is seen as a class: of the answer to a query that is one value the value is the answer."""
    answers = {query.gives for component in document.components for query in component.queries}
    arguments = {command.takes for component in document.components for command in component.commands}
    return name not in arguments and not (name in answers and len(document.payloads[name].fields) == 1)


def _payload(payload: Structure, *, partial: bool) -> str:
    fields = [(field, not (partial or not field.required)) for field in payload.fields]
    members = [
        f"{documented(field.doc)}public {_given(field.type, required)} {_member(payload, field)}"
        " { get; private set; }\n"
        for field, required in fields
    ]
    values = "".join(f"    {_member(payload, field)} = {_reading(field, required)},\n" for field, required in fields)
    read = (
        f"internal static {payload.name} Read(Payload told)\n{{\n"
        f"    return new {payload.name}\n    {{\n{_indented(values[:-2])}\n    }};\n}}\n"
    )
    return block(f"public sealed class {payload.name}", payload.doc, [*members, read], "\n")


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" for line in text.split("\n"))


def _member(payload: Structure, field: Field) -> str:
    name = pascal(field.name)
    return f"{name}Value" if name == payload.name else name


def _given(found: Type, required: bool) -> str:
    """Return the type of a value that the component gives."""
    if isinstance(found, ListOf):
        return f"IReadOnlyList<{_scalar(found.item)}>"
    return _scalar(found) + ("" if required or isinstance(found, Text) else "?")


def _scalar(found: Type) -> str:
    return found.name if isinstance(found, Named) else _SCALARS[type(found)]


def _reading(field: Field, required: bool) -> str:
    """Return the expression that reads a value out of `told`."""
    values = f'("{field.name}", "{field.code}")'
    if isinstance(field.type, ListOf):
        return f"told.{'List' if required else 'FindList'}<{_scalar(field.type.item)}>{values}"
    if isinstance(field.type, Instant | Named):
        verb = "Moment" if isinstance(field.type, Instant) else f"Enumerator<{field.type.name}>"
        return f'told.{"" if required else "Find"}{verb}("{field.name}")'
    if required:
        return f"told.Value<{_scalar(field.type)}>{values}"
    return f"({_given(field.type, required=False)})told.Find{values}"


def _component(document: Document, component: Component, known: Mapping[str, Component]) -> str:
    streams = _has_streams(component)
    base = "Streaming" if streams else next(iter(component.includes), "ComponentProxy")
    inherited = [known[name] for name in component.includes]
    name, new = component.name, "new " if inherited else ""
    members = [
        f'public {new}const string Urn = "{component.urn}";\n',
        f"public static {new}readonly ComponentType<{name}> Type =\n"
        f"    new ComponentType<{name}>(Urn, (client, componentRef) => new {name}(client, componentRef));\n",
        f"public {name}(Client client, string componentRef)\n    : base(client, componentRef)\n{{\n}}\n",
        *_operations(document, component, streams=streams),
        *_names(document, component, inherited),
    ]
    # Only those that include others are ends of the line.
    sealed = "" if any(name in each.includes for each in known.values()) else "sealed "
    return block(f"public {sealed}class {name} : {base}", component.doc, members, "\n")


def _operations(document: Document, component: Component, *, streams: bool) -> Iterator[str]:
    if component.parameters:
        settable = [field for field in document.payloads[component.parameters].fields if not field.read_only]
        if settable:
            yield from _setters(settable)
        yield _async(
            f"Task<{component.parameters}>",
            "GetParametersAsync",
            "Returns the parameters that have a value; the others are null.",
            f"ParametersAsync(Components.{component.parameters}.Read, token)",
        )
    if streams:
        return
    for command in component.commands:
        yield from _command(document, command)
    for query in component.queries:
        yield _query(document, query)
    for event in component.events:
        member = f'get {{ return Event("{event.name}", Components.{event.gives}.Read); }}\n'
        yield block(f"public ComponentEvent<{event.gives}> {pascal(event.name)}", event.doc, [member])


def _setters(fields: Sequence[Field]) -> Iterator[str]:
    parameters = [f"{_taken(field.type)} {camel(field.name)} = null" for field in fields]
    doc = "Changes parameters, all at once; null and those that are not named stay as they are."
    yield _method(
        "Task",
        "SetAsync",
        doc,
        [*parameters, _TOKEN],
        [f"SetStep({', '.join(camel(field.name) for field in fields)}).RunAsync(token)"],
        _param_docs(fields),
    )
    adding = [f'    .Add("{field.name}", "{field.code}", {camel(field.name)})' for field in fields]
    yield _method(
        "Step",
        "SetStep",
        "The same as a step of a sequence.",
        parameters,
        ['Command("set_parameter", new Arguments()', *adding[:-1], f"{adding[-1]})"],
    )


def _command(document: Document, command: Message) -> Iterator[str]:
    fields = document.payloads[command.takes].fields if command.takes else ()
    required = [f"{_taken(field.type, optional=False)} {camel(field.name)}" for field in fields if field.required]
    optional = [f"{_taken(field.type)} {camel(field.name)} = null" for field in fields if not field.required]
    gives = f"<{command.gives}>" if command.gives else ""
    ordered = [field for field in fields if field.required] + [field for field in fields if not field.required]
    name = pascal(command.name)
    yield _method(
        f"Task{gives}",
        f"{name}Async",
        command.doc,
        [*required, *optional, _TOKEN],
        [f"{name}Step({', '.join(camel(field.name) for field in ordered)}).RunAsync(token)"],
        _param_docs(ordered),
    )
    adding = [f'    .Add("{field.name}", "{field.code}", {camel(field.name)})' for field in fields]
    arguments = ["new Arguments()", *adding] if fields else (["null"] if command.gives else [])
    reading = [f"Components.{command.gives}.Read"] if command.gives else []
    call = ", ".join([f'"{command.name}"', "\n".join(arguments), *reading]) if arguments else f'"{command.name}"'
    yield _method(
        f"Step{gives}", f"{name}Step", "The same as a step of a sequence.", [*required, *optional], [f"Command({call})"]
    )


def _query(document: Document, query: Message) -> str:
    fields = document.payloads[query.gives].fields
    kind, read, doc = query.gives, f"Components.{query.gives}.Read", query.doc
    if len(fields) == 1:
        # Of one result the value is the answer.
        kind, read = _given(fields[0].type, fields[0].required), f"told => {_reading(fields[0], fields[0].required)}"
        doc = f"{doc} Returns {fields[0].doc}." if fields[0].doc else doc
    return _async(f"Task<{kind}>", f"{pascal(query.name)}Async", doc, f'QueryAsync("{query.name}", {read}, token)')


def _async(kind: str, name: str, doc: str, expression: str) -> str:
    return _method(kind, name, doc, [_TOKEN], [expression])


def _method(
    kind: str, name: str, doc: str, parameters: Sequence[str], lines: Sequence[str], more_docs: str = ""
) -> str:
    head = f"public {kind} {name}({', '.join(parameters)})"
    if len(head) > 100:
        head = f"public {kind} {name}(\n" + ",\n".join(f"    {each}" for each in parameters) + ")"
    body = "\n        ".join(lines)
    return f"{documented(doc)}{more_docs}{head}\n{{\n    return {body};\n}}\n"


def _param_docs(fields: Iterable[Field]) -> str:
    docs = "".join(f'/// <param name="{camel(each.name)}">{each.doc}</param>\n' for each in fields if each.doc)
    return docs + '/// <param name="token">ends the wait</param>\n' if docs else ""


def _taken(found: Type, *, optional: bool = True) -> str:
    """Return the type of a value that the application gives."""
    if isinstance(found, ListOf):
        return f"IEnumerable<{_scalar(found.item)}>"
    return _scalar(found) + ("?" if optional and not isinstance(found, Text) else "")


def _names(document: Document, component: Component, inherited: Sequence[Component]) -> Iterator[str]:
    """Return classes with the names of all messages, those that are included too, for who writes messages by hand."""
    for kind in ("commands", "queries", "events"):
        messages = [message for each in (*inherited, component) for message in getattr(each, kind)]
        new = "new " if any(getattr(each, kind) for each in inherited) else ""
        if messages:
            constants = [_constant(message.name, message.doc) for message in messages]
            yield block(f"public {new}static class {pascal(kind)}", "", constants)
    if component.parameters:
        fields = document.payloads[component.parameters].fields
        yield block("public static class Parameters", "", [_constant(field.name, field.doc) for field in fields])


def _constant(name: str, doc: str) -> str:
    return f'{documented(doc)}public const string {pascal(name)} = "{name}";\n'
