"""`openrois robot`: the names of robots, and what is said where one cannot run."""

import builtins
import sys
from typing import Any

import pytest
from openrois_robots import command


@pytest.mark.parametrize("arguments", [[], ["unknown"]])
def test_a_robot_has_to_be_named(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main(arguments)
    assert "openrois robot" in capsys.readouterr().err


def test_help_names_the_robots(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        command.main(["--help"])
    assert "simulated" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--gateway", "nonsense"], "nonsense"),
        (["--max-speed", "9"], "base.speed must be between 0.05 and 2, not 9"),
        (["--udp-ports", "9"], "9-9 is not a range of UDP ports"),
        (["--component", "nowhere_at_all:Lamp"], "there is no module nowhere_at_all"),
        (["--voice", "alto"], "--voice: there is no 'alto'; there are espeak, openai, piper"),
    ],
)
def test_wrong_options_end_with_usage(arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main(["simulated", *arguments])
    assert complaint in capsys.readouterr().err


def test_a_token_that_cannot_be_read_ends_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["simulated", "--token-file", "/nowhere/token"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("openrois robot simulated: ")
    assert "/nowhere/token" in said


def test_without_its_extra_it_says_what_to_install(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def lacking(name: str, *arguments: Any, **named: Any) -> Any:
        if name.partition(".")[0] == "panda3d":
            raise ModuleNotFoundError("No module named 'panda3d'", name="panda3d")
        return real(name, *arguments, **named)

    for name in [each for each in sys.modules if each.startswith(("openrois_robots.simulated", "panda3d"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr("openrois.extras.find_spec", lambda _name: None)
    monkeypatch.setattr(builtins, "__import__", lacking)
    assert command.main(["simulated"]) == 1
    told = capsys.readouterr().err
    assert told == "openrois robot simulated: panda3d is not installed: run `pip install 'openrois[robot]'`\n"
