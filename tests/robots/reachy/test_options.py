"""Options and configuration of a Reachy Mini's adapter."""

from pathlib import Path

import pytest
from openrois_robots import command as robots
from openrois_robots.reachy.daemon.address import Address
from openrois_robots.reachy.options import ReachySettings, add_options, read_settings
from openrois_robots.reachy.postures.limits import MotionLimits

from openrois.cli.command_line import CommandLine

pytestmark = pytest.mark.extra(name="reachy")


def read(*arguments: str) -> ReachySettings:
    parser = CommandLine("robot")
    parser.add_argument("--config", type=Path)
    add_options(parser)
    return read_settings(parser.parse_args(arguments))


def test_the_file_has_address_and_speeds_and_the_option_comes_first(tmp_path: Path) -> None:
    file = tmp_path / "reachy.toml"
    file.write_text('[robot]\naddress = "reachy-mini.local"\n[motion]\nhead = 1\nbody = 0.5\nantennas = 2.0\n')
    limits = MotionLimits(1.0, 0.5, 2.0)
    assert read("--config", str(file)) == ReachySettings(Address("reachy-mini.local"), limits)
    assert read("--config", str(file), "--robot", "other:1") == ReachySettings(Address("other", 1), limits)
    assert read("--robot", "192.0.2.7") == ReachySettings(Address("192.0.2.7"))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "--robot is missing: say where the robot is, as in --robot 192.168.1.20"),
        ("[motion]\nhead = 9\n", "motion.head must be between 0.1 and 1.5 rad/s, not 9"),
        ("[wheels]\n", "there is no table 'wheels'; there are robot and motion"),
    ],
)
def test_what_is_wrong_is_said(text: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "reachy.toml"
    file.write_text(text)
    with pytest.raises(ValueError, match=r".+") as raised:
        read("--config", str(file))
    assert sentence in str(raised.value)


def test_a_wrong_address_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        robots.main(["reachy", "--robot", "http://robot"])
    assert "is no port: expected HOST or HOST:PORT, such as 192.168.1.20 or reachy-mini.local:8000" in (
        capsys.readouterr().err
    )
