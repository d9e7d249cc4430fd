"""The other Pythons: a night looks for each one that is promised."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.support.packages import ROOT

SCRIPT = ROOT / ".ci/pythons"


def promised() -> set[str]:
    """Return the Pythons of the classifiers."""
    return set(re.findall(r'"Programming Language :: Python :: (3\.\d+)"', (ROOT / "pyproject.toml").read_text()))


def test_it_looks_for_every_python_but_the_one_of_all_tests() -> None:
    (versions,) = re.findall(r"versions=\((.*?)\)", SCRIPT.read_text())
    assert {"3.11", *versions.split()} == promised()
    assert ".ci/pythons" in (ROOT / "Makefile").read_text()


@pytest.mark.parametrize("command", ["exit 127", "exit 1"], ids=["no such version of pyenv", "another version"])
def test_one_that_is_not_there_is_named(command: str, tmp_path: Path) -> None:
    """A command of that name that does not run, as pyenv has them, is none."""
    for version in ("3.12", "3.13"):
        program = tmp_path / f"python{version}"
        program.write_text(f"#!/bin/sh\n{command}\n")
        program.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "PYENV_ROOT": str(tmp_path / "none")}
    done = subprocess.run([SCRIPT], env=environment, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.splitlines() == [
        f"SKIPPED unit tests with Python {version}: no such interpreter is installed here"
        for version in ("3.12", "3.13")
    ]


def test_a_public_ci_runs_the_same() -> None:
    steps = re.findall(r"^ *- run: (.*)$", (ROOT / ".github/workflows/ci.yml").read_text(), re.MULTILINE)
    assert steps[-1] == ".ci/run"
