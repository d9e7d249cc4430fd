"""The results that are kept are summaries: which command, on which machine, with what outcome; no samples."""

import json
from pathlib import Path
from typing import Any

import pytest
from openrois_bench.measuring.conditions import Conditions
from openrois_bench.measuring.result import write_result

from tests.support.packages import ROOT

RESULTS = sorted((ROOT / "benchmarks/results").glob("*.json"))
ALL_BYTES = 300_000
NUMBERS = 1000
"""Of one result: `openrois bench fanout` reports each run; samples would be thousands."""
CONDITIONS = Conditions(
    cpus=2, processor="P", system="S", python="3", versions={"aiortc": "1"}, load_before=0.1, load_after=0.2
)


def numbers(value: Any) -> int:
    """Count the numbers anywhere in a value of JSON."""
    if isinstance(value, dict):
        return sum(map(numbers, value.values()))
    if isinstance(value, list):
        return sum(map(numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def test_all_results_together_are_small() -> None:
    assert RESULTS
    assert sum(path.stat().st_size for path in RESULTS) <= ALL_BYTES


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_a_result_has_versions_and_no_samples(path: Path) -> None:
    told = json.loads(path.read_text())
    # Those that the page of scale compares its formulas with are of benchmarks that have a result of their own.
    bench = path.stem.removeprefix("scale_")
    assert told.get("command", "").startswith("python -m openrois_bench.") or told["bench"] == bench
    assert told["conditions"]["versions"]
    assert numbers(told) <= NUMBERS


def test_a_result_is_command_machine_and_summary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["program", "--quick"])
    file = tmp_path / "result.json"
    write_result(file, "openrois_bench.x", CONDITIONS, summary=[{"p50": 1.5}], picture="640x360")
    assert json.loads(file.read_text()) == {
        "command": "python -m openrois_bench.x --quick",
        "conditions": CONDITIONS.model_dump(),
        "summary": [{"p50": 1.5}],
        "picture": "640x360",
    }
    write_result(None, "openrois_bench.x", CONDITIONS)
    assert list(tmp_path.iterdir()) == [file]
