"""The units for systemd: what systemd itself says of them, and whether they fit gateway and adapter."""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from openrois_avatar import command as avatar
from openrois_avatar.options.settings import AvatarSettings
from openrois_robots import command as robot
from openrois_robots.adapter.options import AdapterSettings
from openrois_robots.adapter.process import RobotCommand

from openrois.gateway import command
from openrois.gateway.configuration import configure
from tests.support.kachaka_api import needs_kachaka

PACKAGING = Path(__file__).parents[2] / "packaging"
UNIT = PACKAGING / "openrois-gateway.service"
ONE_OF = PACKAGING / "openrois-gateway@.service"
AVATAR = PACKAGING / "openrois-avatar.service"
ROBOT = PACKAGING / "openrois-robot@.service"

needs_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed here")


def entries(unit: Path = UNIT) -> dict[str, list[str]]:
    """Return the values of each key, in their order."""
    found: dict[str, list[str]] = {}
    for line in unit.read_text(encoding="utf-8").splitlines():
        if "=" in line and not line.startswith("#"):
            key, _, value = line.partition("=")
            found.setdefault(key, []).append(value)
    return found


@needs_systemd
@pytest.mark.parametrize("unit", [UNIT, ONE_OF, AVATAR, ROBOT], ids=lambda unit: unit.stem)
def test_systemd_understands_every_line(tmp_path: Path, unit: Path) -> None:
    there = tmp_path / unit.name
    there.write_text(unit.read_text(encoding="utf-8").replace("/opt/openrois/bin/openrois", sys.executable))
    said = subprocess.run(["systemd-analyze", "verify", str(there)], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stdout + said.stderr) == (0, "")


@needs_systemd
def test_systemd_understands_what_is_written_of_ports(tmp_path: Path) -> None:
    page = (PACKAGING.parent / "docs" / "how-to" / "deploying.md").read_text()
    blocks = re.findall(r"```ini\n(.*?)```", page, re.DOTALL)
    (port,) = [block for block in blocks if "CAP_NET_BIND_SERVICE" in block]
    there = tmp_path / UNIT.name
    own = UNIT.read_text(encoding="utf-8").replace("[Install]", port.replace("[Service]", "") + "[Install]")
    there.write_text(own.replace("/opt/openrois/bin/openrois", sys.executable))
    said = subprocess.run(["systemd-analyze", "verify", str(there)], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stdout + said.stderr) == (0, "")


@needs_systemd
@pytest.mark.parametrize(
    ("unit", "threshold"),
    [(UNIT, 15), (ONE_OF, 15), (AVATAR, 15), (ROBOT, 15)],
    ids=["gateway", "one of several", "avatar", "robot"],
)
def test_it_is_exposed_as_little_as_can_be(unit: Path, threshold: int) -> None:
    arguments = ["systemd-analyze", "security", "--offline=true", f"--threshold={threshold}", "--no-pager", str(unit)]
    said = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout[-200:]


def test_it_runs_as_nobody_and_stops_in_good_order() -> None:
    unit = entries()
    assert unit["DynamicUser"] == ["yes"]
    assert unit["Type"] == ["notify"]
    assert "User" not in unit
    assert int(unit["TimeoutStopSec"][0]) > configure([], {}).settings.drain
    assert int(unit["WatchdogSec"][0]) > 0


def test_the_avatar_is_watched_and_bounded_and_runs_with_the_options_of_its_unit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    unit = entries(AVATAR)
    assert (unit["DynamicUser"], unit["Type"], "User" in unit) == (["yes"], ["notify"], False)
    # However long its gateway is not there, it is not killed for that.
    assert unit["TimeoutStartSec"] == ["infinity"]
    assert int(unit["WatchdogSec"][0]) > 0
    assert unit["MemoryMax"] == ["3G"]
    settings: list[AvatarSettings] = []
    monkeypatch.setattr(avatar, "set_up_logging", lambda **_options: None)
    monkeypatch.setattr(avatar, "_serve", settings.append)
    monkeypatch.setattr(avatar, "run_until_stopped", lambda work: work)
    monkeypatch.setattr("uvloop.run", lambda _: None)
    program, command_name, *options = unit["ExecStart"][0].split()
    assert (program, command_name) == ("/opt/openrois/bin/openrois", "avatar")
    given = dict(line.split("=", 1) for line in unit["Environment"])
    options = [given.get(each.strip("${}"), each) if each.startswith("$") else each for each in options]
    assert avatar.main([each for each in options if each]) == 0
    assert settings[0].gateways == ("ws://127.0.0.1:8765/adapter",)
    assert settings[0].metrics == ("127.0.0.1", 9466)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("simulated", "[base]\nspeed = 0.5\n"),
        pytest.param("kachaka", '[robot]\naddress = "192.0.2.7"\n', marks=needs_kachaka),
        ("ros2", '[odometry]\ntopic = "odom"\n'),
    ],
)
def test_a_robot_runs_with_the_options_of_its_unit(
    name: str, text: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    unit = entries(ROBOT)
    assert (unit["DynamicUser"], unit["Type"], unit["TimeoutStartSec"]) == (["yes"], ["notify"], ["infinity"])
    assert int(unit["WatchdogSec"][0]) > 0
    config = tmp_path / "robot.toml"
    config.write_text(text)
    settings: list[tuple[AdapterSettings, Any]] = []
    monkeypatch.setattr("openrois_robots.adapter.process.set_up_logging", lambda **_options: None)
    monkeypatch.setattr(RobotCommand, "_serve", lambda _self, *read: settings.append(read))
    monkeypatch.setattr("openrois_robots.adapter.process.run_until_stopped", lambda work: work)
    monkeypatch.setattr("uvloop.run", lambda _: None)
    program, command_name, *options = unit["ExecStart"][0].replace("%i", name).split()
    assert (program, command_name) == ("/opt/openrois/bin/openrois", "robot")
    given = dict(line.split("=", 1) for line in unit["Environment"])
    options = [given.get(each.strip("${}"), each) if each.startswith("$") else each for each in options]
    options = [str(config) if each == f"/etc/openrois/robot-{name}.toml" else each for each in options]
    assert robot.main([each for each in options if each]) == 0
    assert settings[0][0].gateways == ("ws://127.0.0.1:8765/adapter",)
    assert settings[0][0].metrics == ("127.0.0.1", 9467)
    own = settings[0][1]
    read = {
        "simulated": lambda: own.base.speed == 0.5,
        "kachaka": lambda: own.address.text == "192.0.2.7:26400",
        "ros2": lambda: own.odometry.topic == "/odom",
    }
    assert read[name]()


def test_a_configuration_that_cannot_be_used_is_not_tried_again() -> None:
    with pytest.raises(SystemExit) as refused:
        command.main(["--config", "/nowhere/gateway.toml"])
    assert entries()["RestartPreventExitStatus"] == [str(refused.value.code)]


def test_who_deploys_it_installs_what_it_reads_for_its_group_and_nobody_else() -> None:
    unit = entries()
    (group,) = unit["SupplementaryGroups"]
    steps = (PACKAGING.parent / "docs" / "how-to" / "deploying.md").read_text(encoding="utf-8")
    assert f"groupadd --system {group}\n" in steps
    (installed,) = re.findall(rf"install -m 0640 -g {group} (.*) /etc/openrois/\n", steps)
    settings = configure(["--config", str(PACKAGING / "gateway.toml")], {}).settings
    read = [*settings.auth_keys, settings.tls_cert, settings.tls_key]
    assert set(installed.split()) == {"packaging/gateway.toml", *(path.name for path in read if path is not None)}
    assert "--config /etc/openrois/gateway.toml" in unit["ExecStart"][0]
    kept = [path for path in (settings.audit_file, settings.journal) if path is not None]
    assert {str(path.parent) for path in kept} == {f"/var/lib/{unit['StateDirectory'][0]}"}
