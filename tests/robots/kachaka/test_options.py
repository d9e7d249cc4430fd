"""Options and configuration of a Kachaka's adapter, and its command."""

import asyncio
import signal
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest
from openrois_robots import command as robots
from openrois_robots.adapter.battery import BatteryLimit
from openrois_robots.kachaka.api.address import Address
from openrois_robots.kachaka.limits import DrivingLimits, SpeechSettings
from openrois_robots.kachaka.options import KachakaSettings, add_options, read_settings

from openrois.cli.command_line import CommandLine
from openrois.client import Client
from openrois.client.components import SystemInformation
from tests.support.deployment import gateway
from tests.support.kachaka import simulator_process


def read(*arguments: str) -> KachakaSettings:
    parser = CommandLine("robot")
    parser.add_argument("--config", type=Path)
    add_options(parser)
    return read_settings(parser.parse_args(arguments))


def test_the_address_is_enough() -> None:
    assert read("--robot", "192.0.2.7") == KachakaSettings(Address("192.0.2.7"))


def test_the_file_has_address_and_limits_and_the_option_comes_first(tmp_path: Path) -> None:
    file = tmp_path / "kachaka.toml"
    file.write_text(
        """
        [robot]
        address = "kachaka.local"
        [driving]
        speed = 0.2
        turn = 1
        [speech]
        while_driving = "refuse"
        [battery]
        low = 30
        """
    )
    limits = DrivingLimits(0.2, 1.0), SpeechSettings("refuse"), BatteryLimit(30.0)
    assert read("--config", str(file)) == KachakaSettings(Address("kachaka.local"), *limits)
    assert read("--config", str(file), "--robot", "other:1") == KachakaSettings(Address("other", 1), *limits)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "--robot is missing: say where the robot is, as in --robot 192.168.1.20"),
        ("[driving]\nspeed = 3\n", "driving.speed must be between 0.05 and 0.3, not 3"),
        ("[speech]\nwhile_driving = true\n", "speech.while_driving must be text, not True"),
        ("[wheels]\n", "there is no table 'wheels'; there are robot, driving, speech and battery"),
    ],
)
def test_what_is_wrong_is_said(text: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "kachaka.toml"
    file.write_text(text)
    with pytest.raises(ValueError, match=r".+") as raised:
        read("--config", str(file))
    assert sentence in str(raised.value)


def test_a_wrong_address_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        robots.main(["kachaka", "--robot", "http://robot"])
    assert "is no port: expected HOST or HOST:PORT" in capsys.readouterr().err


class Version(NamedTuple):
    """Version of a Python."""

    major: int
    minor: int


def test_a_python_without_the_api_is_told_what_to_do(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robots, "find_spec", lambda _name: None)
    monkeypatch.setattr(robots, "sys", SimpleNamespace(version_info=Version(3, 13), stderr=sys.stderr))
    assert robots.main(["kachaka", "--robot", "192.0.2.7"]) == 1
    assert capsys.readouterr().err == (
        "openrois robot kachaka: the Kachaka API needs Python 3.12 or older, and this is 3.13:"
        " run `python3.12 -m venv kachaka` and `kachaka/bin/pip install 'openrois[kachaka]'`,"
        " and start the robot with `kachaka/bin/openrois`\n"
    )


async def test_it_runs_behind_a_gateway_until_a_signal() -> None:
    async with gateway() as running, simulator_process() as home:
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            *("-m", "openrois.cli", "robot", "kachaka"),
            *("--gateway", running.url, "--robot", home.address.text),
            stdout=asyncio.subprocess.PIPE,
        )
        try:
            assert process.stdout is not None
            async with asyncio.timeout(60):
                assert await process.stdout.readline() == b"ready kachaka\n"
                async with Client(running.url.replace("http", "ws", 1)) as client:
                    information: Any = await client.find(SystemInformation)
                    while (await information.engine_status()).status.value != "READY":  # noqa: ASYNC110
                        await asyncio.sleep(0.1)
                    assert (await information.query("pose"))["frame"] == "map"
                process.send_signal(signal.SIGTERM)
                assert await process.wait() == 0
        finally:
            if process.returncode is None:
                process.kill()
                await process.wait()
