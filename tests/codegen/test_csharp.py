"""The C# types: they compile, read and write every message of the corpus, and refuse what is none."""

import json
from pathlib import Path
from typing import Any

import pytest
from openrois_codegen.wire import sources
from pydantic import TypeAdapter

from tests.support.corpus import FOLDER, corpus
from tests.support.mono import Mono

pytestmark = pytest.mark.timeout(120)

LEFT_TO_THE_ENGINE = {"range", "rule"}
"""Limits and rules, which the C# types do not check: they come with the engine's answer."""


@pytest.fixture(scope="module")
def told(
    mono: Mono, csharp_library: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, bool, str], dict[str, Any]]:
    """What came of each case when C# read it and wrote it again."""
    sources = [Path(__file__).with_name("RoundTrip.cs")]
    program = mono.compile(sources, tmp_path_factory.mktemp("round_trip"), csharp_library)
    lines = [json.loads(line) for line in mono.run(program, str(FOLDER)).splitlines()]
    return {(line["type"], line["valid"], line["name"]): line for line in lines}


def test_no_case_is_left_out(told: dict[tuple[str, bool, str], dict[str, Any]]) -> None:
    assert set(told) == {(name, case.is_valid, case.name) for name, cases in corpus().items() for case in cases}


@pytest.mark.parametrize("name", sorted(corpus()))
def test_what_it_reads_and_writes_is_the_same_message(
    told: dict[tuple[str, bool, str], dict[str, Any]], name: str
) -> None:
    adapter = TypeAdapter(sources()[name])
    for case in corpus()[name]:
        if case.is_valid:
            line = told[name, True, case.name]
            assert "written" in line, line
            assert adapter.validate_json(line["written"]) == adapter.validate_python(case.message), case.name


@pytest.mark.parametrize("name", sorted(corpus()))
def test_it_refuses_what_is_no_such_message(told: dict[tuple[str, bool, str], dict[str, Any]], name: str) -> None:
    wrong = [case for case in corpus()[name] if not case.is_valid and case.kind not in LEFT_TO_THE_ENGINE]
    assert [case.name for case in wrong if "refused" not in told[name, False, case.name]] == []


NULLS = """
public static class Nulls
{
    public static void Main()
    {
        var bare = new OpenRoIS.RoISIdentifier { Code = "x", Authority = null, CodebookRef = null, Version = null };
        System.Console.WriteLine(OpenRoIS.RoISJson.Write(bare));
        try
        {
            OpenRoIS.RoISJson.Write(new OpenRoIS.RoISIdentifier());
        }
        catch (Newtonsoft.Json.JsonException)
        {
            System.Console.WriteLine("refused");
        }
    }
}
"""


def test_null_is_never_written_where_the_wire_has_none(mono: Mono, csharp_library: Path, tmp_path: Path) -> None:
    source = tmp_path / "Nulls.cs"
    source.write_text(NULLS, encoding="utf-8")
    assert mono.run(mono.compile([source], tmp_path, csharp_library)).splitlines() == ['{"code":"x"}', "refused"]
