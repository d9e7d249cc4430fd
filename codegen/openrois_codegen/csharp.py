"""C#: the wire's types with Newtonsoft's attributes, and typed method names; C# 6 for Unity.

Pure.
"""

import json
from typing import Final

from openrois_codegen.csharp_source import block, documented, source_file
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
from openrois_codegen.names import pascal

__all__ = ["methods", "types"]

_OUTCOME: Final = "IOutcome"
"""What every result of a method is: it has a return code."""


def types(document: Document) -> str:
    """Return the file of the wire's types."""
    interfaces = {
        member: f"I{union.name}"
        for union in document.definitions.values()
        if isinstance(union, Union)
        for member in union.members
    }
    parts = []
    for found in document.definitions.values():
        if isinstance(found, Enumeration):
            parts.append(_enumeration(found))
        elif isinstance(found, Union):
            parts += [_interface(found), _converter(document, found)]
        else:
            parts.append(_class(document, found, interfaces.get(found.name, "")))
    parts.append(_unions(document))
    return source_file(
        "OpenRoIS",
        "Types of the wire.",
        parts,
        "System",
        "System.Collections.Generic",
        "System.Runtime.Serialization",
        "Newtonsoft.Json",
        "Newtonsoft.Json.Linq",
    )


def methods(document: Document) -> str:
    """Return the file of methods and notifications."""
    requests = [
        _static(method.name, method.doc, f"Method<{method.params}, {method.result}>") for method in document.methods
    ]
    told = [_static(found.name, found.doc, f"Notification<{found.params}>") for found in document.notifications]
    return source_file(
        "OpenRoIS",
        "Methods and notifications of the wire.",
        [
            block("public static class Methods", "What an application may call.", requests),
            block("public static class Notifications", "What an application may be told.", told),
        ],
    )


def _enumeration(found: Enumeration) -> str:
    members = [f'[EnumMember(Value = "{member}")]\n{_member(member)},\n' for member in found.members]
    return block(f"public enum {found.name}", found.doc, members)


def _member(name: str) -> str:
    return pascal(name.lower())


def _interface(union: Union) -> str:
    return f"{documented(union.doc)}public interface I{union.name}\n{{\n}}\n"


def _converter(document: Document, union: Union) -> str:
    """Return the converter that tells members apart by the field that each alone has; the first needs none."""
    first, *others = union.members
    choices = "".join(
        f'    if (read["{_own_field(document, union, member)}"] != null)\n'
        f"    {{\n        return read.ToObject<{member}>(serializer);\n    }}\n"
        for member in others
    )
    return block(
        f"public sealed class {union.name}Converter : ReadingConverter",
        f"Reads each {union.name} as the type that it is.",
        [
            f"public override bool CanConvert(Type type)\n{{\n    return type == typeof(I{union.name});\n}}\n",
            "public override object ReadJson(\n"
            "    JsonReader reader, Type type, object existing, JsonSerializer serializer)\n"
            f"{{\n    JObject read = JObject.Load(reader);\n{choices}"
            f"    return read.ToObject<{first}>(serializer);\n}}\n",
        ],
        "\n",
    )


def _unions(document: Document) -> str:
    names = [found.name for found in document.definitions.values() if isinstance(found, Union)]
    made = ", ".join(f"new {name}Converter()" for name in names)
    return block(
        "internal static class Unions",
        "The converters of all unions.",
        [f"internal static readonly JsonConverter[] Converters = {{ {made} }};\n"],
    )


def _own_field(document: Document, union: Union, member: str) -> str:
    others = {name for other in union.members if other != member for name in _required(document, other)}
    return next(name for name in _required(document, member) if name not in others)


def _required(document: Document, name: str) -> list[str]:
    structure = document.definitions[name]
    assert isinstance(structure, Structure)
    return [field.name for field in structure.fields if field.required]


def _class(document: Document, structure: Structure, interface: str) -> str:
    members = [_property(document, structure, field) for field in structure.fields]
    is_outcome = any(field.type == Named("ReturnCode") and field.required for field in structure.fields)
    interfaces = [*([interface] if interface else []), *([_OUTCOME] if is_outcome else [])]
    implemented = f" : {', '.join(interfaces)}" if interfaces else ""
    return block(f"public sealed class {structure.name}{implemented}", structure.doc, members, "\n")


def _property(document: Document, structure: Structure, field: Field) -> str:
    name = pascal(field.name)
    if name == structure.name:
        name += "Value"  # no member of a C# class is named like the class
    null = "?" if field.nullable and _is_value(document, field.type) else ""
    lines = [f"[JsonProperty({_attribute(field)})]"]
    if field.required and field.nullable:
        lines.append("[JsonConverter(typeof(TextOrNullConverter))]")
    if isinstance(field.type, Identity):
        lines.append("[JsonConverter(typeof(IdentityConverter))]")
    lines.append(f"public {_type(document, field.type)}{null} {name} {{ get; set; }}{_initial(document, field)}")
    return documented(field.doc) + "\n".join(lines) + "\n"


def _attribute(field: Field) -> str:
    if field.required:
        return f'"{field.name}", Required = Required.{"AllowNull" if field.nullable else "Always"}'
    return f'"{field.name}"' + (", NullValueHandling = NullValueHandling.Ignore" if field.nullable else "")


def _initial(document: Document, field: Field) -> str:
    """Return the initializer of what has a default, so that nothing is null that the wire does not allow to be."""
    if isinstance(field.type, ListOf | MapOf) and not field.nullable:
        items = field.default if isinstance(field.default, list) else []
        given = f" {{ {', '.join(_quoted(item) for item in items)} }}" if items else "()"
        return f" = new {_type(document, field.type)}{given};"
    if field.required or field.nullable:
        return ""
    if isinstance(field.type, Named):
        return f" = {field.type.name}.{_member(str(field.default))};"
    return f" = {_quoted(field.default)};"


def _quoted(default: object) -> str:
    """Return a text or a number as C# writes it, which is as JSON does."""
    return json.dumps(default)


def _is_value(document: Document, found: Type) -> bool:
    if isinstance(found, Named):
        return isinstance(document.definitions[found.name], Enumeration)
    return isinstance(found, Integer)


def _type(document: Document, found: Type) -> str:
    if isinstance(found, Text):
        return "string"
    if isinstance(found, Identity):
        return "object"
    if isinstance(found, Integer):
        return "int" if _fits_int(found.minimum) and _fits_int(found.maximum) else "long"
    if isinstance(found, ListOf):
        return f"List<{_type(document, found.item)}>"
    if isinstance(found, MapOf):
        return f"Dictionary<string, {_type(document, found.item)}>"
    if isinstance(found, Named):
        return ("I" if isinstance(document.definitions[found.name], Union) else "") + found.name
    raise TypeError(f"{found} stands in the text of a value, never in a message")


def _fits_int(limit: int | None) -> bool:
    return limit is not None and -(2**31) <= limit < 2**31


def _static(wire_name: str, doc: str, kind: str) -> str:
    name = pascal(wire_name.removeprefix("openrois.").removeprefix("rois."))
    return f'{documented(doc)}public static readonly {kind} {name} =\n    new {kind}("{wire_name}");\n'
