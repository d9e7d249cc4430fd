"""The emitters, where what is committed does not show it: long lines, names that clash, and types without a place."""

import json
from dataclasses import replace
from typing import Any

import jsonschema
import pytest
from openrois_codegen import csharp, json_schema, names, openrpc, typescript
from openrois_codegen.ir import (
    Definition,
    Document,
    Enumeration,
    Field,
    Integer,
    ListOf,
    MapOf,
    Method,
    Named,
    Notification,
    Number,
    Structure,
    Text,
    Union,
)
from openrois_codegen.wire import document


def of(*definitions: Definition) -> Document:
    """Return a document with nothing but types."""
    return Document("2026-01-01", {found.name: found for found in definitions}, (), (), (), {})


def structure(name: str, *fields: Field) -> Structure:
    return Structure(name, "", fields)


class TestNames:
    @pytest.mark.parametrize(
        ("wire", "pascal", "camel"),
        [
            ("get_command_result", "GetCommandResult", "getCommandResult"),
            ("rois.query.query", "RoisQueryQuery", "roisQueryQuery"),
            ("start", "Start", "start"),
            ("sdp_m_line_index", "SdpMLineIndex", "sdpMLineIndex"),
        ],
    )
    def test_of_messages(self, wire: str, pascal: str, camel: str) -> None:
        assert (names.pascal(wire), names.camel(wire)) == (pascal, camel)

    def test_of_constants(self) -> None:
        assert names.constant("ReachedTarget") == "REACHED_TARGET"

    def test_the_first_paragraph_is_one_line(self) -> None:
        assert names.first_paragraph("One\ntwo.\n\nThree.") == "One two."


class TestTypeScript:
    def test_a_line_is_broken_where_it_is_too_long(self) -> None:
        written = typescript.types(of(Enumeration("Long", "", tuple(f"A_RATHER_LONG_NAME_{n}" for n in range(6)))))
        assert 'export const Long = [\n  "A_RATHER_LONG_NAME_0",\n' in written
        assert "\n] as const;\nexport type Long = (typeof Long)[number];\n" in written

    def test_so_is_a_comment(self) -> None:
        written = typescript.types(of(Structure("X", "word " * 30, (Field("a", Text(), required=True),))))
        assert "/**\n * word word" in written
        assert max(len(line) for line in written.splitlines()) <= 110

    def test_optional_and_null_are_two_things(self) -> None:
        written = typescript.types(
            of(
                structure(
                    "X",
                    Field("both", Integer(), required=False, nullable=True),
                    Field("absent", ListOf(Text()), required=False),
                    Field("null", MapOf(Named("X")), required=True, nullable=True),
                )
            )
        )
        assert "  readonly both?: number | null;\n" in written
        assert "  readonly absent?: readonly string[];\n" in written
        assert "  readonly null: { readonly [name: string]: X } | null;\n" in written

    def test_a_union(self) -> None:
        assert "export type U = A | B;\n" in typescript.types(of(Union("U", "", ("A", "B"))))


class TestCSharp:
    def test_a_member_is_not_named_like_its_class(self) -> None:
        written = csharp.types(of(structure("Candidate", Field("candidate", Text(), required=True))))
        assert "public string CandidateValue { get; set; }" in written

    @pytest.mark.parametrize(
        ("limits", "kind"),
        [(Integer(), "long"), (Integer(0), "long"), (Integer(0, 2**31 - 1), "int"), (Integer(0, 2**31), "long")],
    )
    def test_a_number_fits_its_type(self, limits: Integer, kind: str) -> None:
        written = csharp.types(of(structure("X", Field("n", limits, required=True))))
        assert f"public {kind} N {{ get; set; }}" in written

    @pytest.mark.parametrize(
        ("field", "written"),
        [
            (Field("f", Integer(), required=False, default=7), "public long F { get; set; } = 7;"),
            (Field("f", Integer(), required=False, nullable=True), "public long? F { get; set; }\n"),
            (Field("f", Text(), required=False, default='a "b"\\'), 'public string F { get; set; } = "a \\"b\\"\\\\";'),
            (
                Field("f", ListOf(Text()), required=False, default=["a"]),
                'public List<string> F { get; set; } = new List<string> { "a" };',
            ),
        ],
    )
    def test_a_default(self, field: Field, written: str) -> None:
        assert written in csharp.types(of(structure("X", field)))

    def test_a_type_that_is_in_texts_only(self) -> None:
        with pytest.raises(TypeError, match="never in a message"):
            csharp.types(of(structure("X", Field("n", Number(), required=True))))


class TestJsonSchema:
    def schema(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(json_schema.emit(document()))
        return found

    def test_it_is_a_schema(self) -> None:
        schema = self.schema()
        assert schema["$schema"] == json_schema.DIALECT
        jsonschema.Draft202012Validator.check_schema(schema)

    def test_it_is_sorted_and_closed(self) -> None:
        schema = self.schema()
        assert json.dumps(schema, indent=2, sort_keys=True, ensure_ascii=False) + "\n" == json_schema.emit(document())
        objects = [found for found in schema["$defs"].values() if found.get("type") == "object"]
        assert objects
        assert all(found["additionalProperties"] is False for found in objects)

    def test_every_type_has_its_name_as_title(self) -> None:
        assert [name for name, found in self.schema()["$defs"].items() if found["title"] != name] == []

    def test_every_reference_leads_somewhere(self) -> None:
        defined = {f"#/$defs/{name}" for name in self.schema()["$defs"]}
        assert set(references(self.schema())) <= defined

    def test_a_type_that_is_in_texts_only(self) -> None:
        with pytest.raises(TypeError, match="never in a message"):
            json_schema.emit(of(structure("X", Field("n", Number(), required=True))))


class TestOpenRpc:
    def found(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(openrpc.emit(document()))
        return found

    def test_it_has_what_openrpc_asks_for(self) -> None:
        found = self.found()
        assert set(found) == {"openrpc", "info", "methods", "components", "x-notifications"}
        assert {"title", "version"} <= set(found["info"])
        for method in found["methods"]:
            assert {"name", "params", "result"} <= set(method)
            assert method["paramStructure"] == "by-name"
            assert all({"name", "schema"} <= set(param) for param in (*method["params"], method["result"]))
            assert method["x-since"]
        assert all(set(error) == {"code", "message"} for error in found["components"]["errors"].values())

    def test_every_reference_leads_somewhere(self) -> None:
        found = self.found()
        places = {f"#/components/{kind}/{name}" for kind, named in found["components"].items() for name in named}
        assert set(references(found)) <= places

    def test_what_may_be_left_out_stands_last(self) -> None:
        for method in self.found()["methods"]:
            required = [param["required"] for param in method["params"]]
            assert required == sorted(required, reverse=True), method["name"]

    def test_a_name_stands_once(self) -> None:
        for listed in (self.found()["methods"], self.found()["x-notifications"]):
            assert len({found["name"] for found in listed}) == len(listed)

    def test_base_and_extensions_are_told_apart(self) -> None:
        tagged = {method["name"]: method["tags"][0]["name"] for method in self.found()["methods"]}
        assert list(tagged.values()).count("base") == 16
        assert tagged["rois.stream.connect_stream"] == "rois.stream"
        assert tagged["signaling.answer"] == "signaling"

    def test_versions(self) -> None:
        params = structure("P")
        made = replace(
            of(params),
            methods=(Method("m", "Do.", "P", "P", "x", "7"),),
            notifications=(Notification("n", "Done.", "P", "", "2.0"),),
        )
        found = json.loads(openrpc.emit(made))
        assert found["info"]["version"] == "2026-01-01"
        assert (found["methods"][0]["x-since"], found["x-notifications"][0]["x-since"]) == ("7", "2.0")


def references(found: Any) -> list[str]:
    """Return every `$ref` in a document."""
    if isinstance(found, dict):
        own = [found["$ref"]] if isinstance(found.get("$ref"), str) else []
        return [*own, *(ref for value in found.values() for ref in references(value))]
    return [ref for value in found for ref in references(value)] if isinstance(found, list) else []
