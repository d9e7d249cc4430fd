"""A small world through half a virtual day, each in a process of its own: its clocks are virtual."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any, Self

import pytest

WORLD = ("--bodies", "8", "--applications", "24", "--gateways", "2", "--rush", "2")
DAY = 12 * 3600


Found = dict[str, Any]


class Run:
    """A program that has begun, so that several can run at the same time."""

    def __init__(self, file: Path, *more: str) -> None:
        self._file = file
        program = [sys.executable, "-P", "-m", "openrois_bench.simulation", *WORLD, *more, "--json", str(file)]
        self._process = subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self._process.kill()
        self._process.communicate()

    def found(self) -> tuple[Found, str]:
        """Wait for its end, and return its figures and what it printed."""
        said, told = self._process.communicate(timeout=120)
        assert self._process.returncode == 0, told
        # Exceptions of tasks that no task awaits are told there.
        assert "Traceback" not in told
        assert "never retrieved" not in told
        return json.loads(self._file.read_text()), said


@pytest.fixture(scope="module")
def twice(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Found, str]]:
    folder = tmp_path_factory.mktemp("simulation")
    with Run(folder / "first.json") as first, Run(folder / "again.json") as again:
        return [first.found(), again.found()]


def test_each_kind_of_work_is_done(twice: list[tuple[Found, str]]) -> None:
    found, said = twice[0]
    assert found["virtual_seconds"] > DAY
    # Each body came once, restarted and was lost once each for a measurement, and restarted once in the day or more.
    assert found["messages"]["attached"] >= 4 * 8
    assert found["messages"]["sessions"] == 24 + found["messages"]["returns"]
    assert found["messages"]["fault checks"] >= 8 * 12
    for kind in (
        *("queries", "pipelined queries", "commands", "subscriptions", "deliveries", "burst deliveries", "streams"),
        *("signs of life", "changes", "hops"),
    ):
        assert found["messages"][kind] > 0, kind
    assert found["cost_us"]["query"] > 0
    assert found["memory"]["session_kib"] > 10
    assert set(found["loads"]) == {"rush", "day"}
    assert "it saturates at" in said
    assert "by the formulas" in said


def test_the_same_seed_has_the_same_messages(twice: list[tuple[Found, str]]) -> None:
    (first, _), (again, _) = twice
    assert again["messages"] == first["messages"]


@pytest.mark.long
def test_another_seed_has_others(twice: list[tuple[Found, str]], tmp_path: Path) -> None:
    with Run(tmp_path / "other.json", "--seed", "2") as run:
        other, _ = run.found()
    assert other["messages"] != twice[0][0]["messages"]


@pytest.mark.long
def test_the_same_peers_stand_before_a_real_gateway(tmp_path: Path) -> None:
    with Run(tmp_path / "real.json", "--real", "--pace", "10") as run:
        found, _ = run.found()
    assert found["messages"]["attached"] >= 3 * 8
    assert found["cost_us"]["session"] > 0
    assert set(found["loads"]) == {"rush"}
