"""The `openrois` command finds its sub-commands among the entry points."""

import subprocess
import sys
from importlib.metadata import entry_points

import pytest

from openrois.cli import main
from openrois.version import __version__


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_usage_names_every_command(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 0
    shown = capsys.readouterr().out
    assert all(f"openrois {entry.name}\n" in shown for entry in entry_points(group="openrois.commands"))


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"openrois {__version__}\n"


def test_an_unknown_command_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dance"]) == 2
    assert "there is no command 'dance'" in capsys.readouterr().err


def test_the_rest_goes_to_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as raised:
        main(["gateway", "--help"])
    assert raised.value.code == 0
    assert "usage: openrois gateway" in capsys.readouterr().out


def test_it_reads_the_process_arguments(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["openrois", "--version"])
    assert main() == 0
    assert capsys.readouterr().out


def test_it_runs_as_a_module() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "openrois.cli", "--version"], capture_output=True, check=True, text=True, timeout=20
    )
    assert shown.stdout == f"openrois {__version__}\n"
