"""The `openrois` command finds its sub-commands among the entry points."""

import re
import subprocess
import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

import pytest

from openrois.cli.__main__ import main
from openrois.version import __version__


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_usage_names_every_command(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 0
    shown = capsys.readouterr().out
    for entry in entry_points(group="openrois.commands"):
        assert re.search(rf"^  {entry.name} +\w.+\w$", shown, re.MULTILINE), entry.name
    assert re.search(r"^  gateway +run a gateway until it is stopped$", shown, re.MULTILINE)


@pytest.mark.parametrize("text", ["import gone\n", '"""Dances."""', '"""', None])
def test_a_command_that_does_not_describe_itself_is_named(
    text: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if text is not None:
        (tmp_path / "dancing.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    entry = EntryPoint("dance", "dancing:main", "openrois.commands")
    monkeypatch.setattr("openrois.cli.__main__.entry_points", lambda *, group: [entry])
    assert main([]) == 0
    assert "\n  dance\n" in capsys.readouterr().out


def test_the_list_of_commands_imports_none() -> None:
    heavy = "[name for name in sys.modules if name in ('av', 'aiohttp')]"
    script = f"import sys; from openrois.cli.__main__ import main; main([]); print({heavy})"
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True, timeout=20)
    assert shown.stdout.splitlines()[-1] == "[]"


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"openrois {__version__}\n"


def test_an_unknown_command_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dance"]) == 2
    assert capsys.readouterr().err == "openrois: there is no command 'dance' (`openrois --help` lists them)\n"
    assert main(["gatewy"]) == 2
    assert "there is no command 'gatewy'; is it gateway?" in capsys.readouterr().err


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
