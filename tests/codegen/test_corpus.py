"""The corpus: what is valid by construction is, and what is not is refused, by the models and by their schema."""

import json
from typing import Any, TypeGuard

import jsonschema
import pytest
from openrois_codegen.corpus import cases
from openrois_codegen.ir import Document, Field, Structure, Text
from openrois_codegen.json_schema import emit
from openrois_codegen.wire import document, sources
from pydantic import TypeAdapter, ValidationError

from openrois.schema import VERSION
from openrois.types.messages import ReturnResult
from openrois.types.values import decode_value
from tests.support.corpus import FOLDER, Case, corpus

TYPES = sorted(corpus())
SCHEMA: dict[str, Any] = json.loads(emit(document()))
VALUES: dict[str, Any] = json.loads((FOLDER / "values" / "values.json").read_text(encoding="utf-8"))


def value_id(case: dict[str, Any]) -> str:
    return f"{case['type']} {case['text'][:20]}"


def is_result(source: Any) -> TypeGuard[type[ReturnResult]]:
    """Tell whether a type is that of a method's results."""
    return isinstance(source, type) and issubclass(source, ReturnResult)


def accepts(source: Any, message: Any) -> bool:
    """Tell whether the model reads a message as it comes off the wire."""
    try:
        if is_result(source):
            source.read(message)
        else:
            TypeAdapter(source).validate_python(message)
    except ValidationError:
        return False
    return True


def misjudged(name: str, judged: list[tuple[Case, bool]]) -> list[str]:
    return [f"{name}: {case.name}" for case, verdict in judged if verdict is not case.is_valid]


def test_every_type_has_cases() -> None:
    assert set(corpus()) == set(document().definitions) == set(sources())
    assert sum(len(found) for found in corpus().values()) > 3000
    assert {case.kind for found in corpus().values() for case in found} == {
        "", "missing", "unknown", "null", "type", "name", "range", "rule",
    }  # fmt: skip


@pytest.mark.parametrize("name", TYPES)
def test_every_case_has_a_name_of_its_own(name: str) -> None:
    names = [(case.name, case.is_valid) for case in corpus()[name]]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("name", TYPES)
def test_the_models_judge_as_the_corpus_does(name: str) -> None:
    source = sources()[name]
    # What a newer program adds to results is passed over: tests/openrois/types/test_newer.py.
    told = [case for case in corpus()[name] if case.kind != "unknown" or not is_result(source)]
    assert misjudged(name, [(case, accepts(source, case.message)) for case in told]) == []


@pytest.mark.parametrize("name", TYPES)
def test_the_schema_judges_as_the_corpus_does(name: str) -> None:
    validator = jsonschema.Draft202012Validator({"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]})
    told = [case for case in corpus()[name] if case.kind != "rule"]
    assert misjudged(name, [(case, validator.is_valid(case.message)) for case in told]) == []


@pytest.mark.parametrize("name", TYPES)
def test_what_is_valid_is_written_as_it_was_meant(name: str) -> None:
    adapter = TypeAdapter(sources()[name])
    for case in corpus()[name]:
        if case.is_valid:
            read = adapter.validate_python(case.message)
            assert adapter.validate_json(adapter.dump_json(read)) == read, case.name


def test_its_folder_is_named_after_the_schema() -> None:
    assert FOLDER.name == VERSION
    assert {path.suffix for path in FOLDER.rglob("*") if path.is_file()} == {".json"}


@pytest.mark.parametrize("case", VALUES["valid"], ids=value_id)
def test_a_value_is_read(case: dict[str, Any]) -> None:
    read = decode_value(case["type"], case["text"])
    assert (read, type(read)) == (case["value"], type(case["value"]))


@pytest.mark.parametrize("case", VALUES["invalid"], ids=value_id)
def test_what_is_no_such_value_is_refused(case: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"JSON array|is not of type"):
        decode_value(case["type"], case["text"])


def test_no_sample_is_longer_than_its_type_allows() -> None:
    short = Structure("Short", "", (Field("text", Text(1, 5), required=True),))
    made = cases(Document("", {"Short": short}, (), (), (), {}), "Short")
    lengths = {case.name: len(case.message["text"]) for case in made if not case.kind}
    assert max(lengths.values()) == 5
    assert min(lengths.values()) == 1
    assert "text: like a date" not in lengths
