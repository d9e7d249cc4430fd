"""The unit for systemd: what systemd itself says of it, and whether it fits the gateway."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from openrois.gateway.configuration import configure, settings_of

PACKAGING = Path(__file__).parents[2] / "packaging"
UNIT = PACKAGING / "openrois-gateway.service"

needs_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed here")


def entries() -> dict[str, list[str]]:
    """Return the values of each key, in their order."""
    found: dict[str, list[str]] = {}
    for line in UNIT.read_text(encoding="utf-8").splitlines():
        if "=" in line and not line.startswith("#"):
            key, _, value = line.partition("=")
            found.setdefault(key, []).append(value)
    return found


@needs_systemd
def test_systemd_understands_every_line(tmp_path: Path) -> None:
    there = tmp_path / UNIT.name
    there.write_text(UNIT.read_text(encoding="utf-8").replace("/opt/openrois/bin/openrois", sys.executable))
    said = subprocess.run(["systemd-analyze", "verify", str(there)], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stdout + said.stderr) == (0, "")


@needs_systemd
def test_it_is_exposed_as_little_as_can_be() -> None:
    arguments = ["systemd-analyze", "security", "--offline=true", "--threshold=15", "--no-pager", str(UNIT)]
    said = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout[-200:]


def test_it_runs_as_nobody_and_stops_in_good_order() -> None:
    unit = entries()
    assert unit["DynamicUser"] == ["yes"]
    assert unit["Type"] == ["notify"]
    assert "User" not in unit
    assert int(unit["TimeoutStopSec"][0]) > configure([], {}).settings.drain
    assert int(unit["WatchdogSec"][0]) > 0


def test_the_secrets_are_copies_that_the_gateway_is_told_of() -> None:
    unit = entries()
    copies = {line.partition(":")[0] for line in unit["LoadCredential"]}
    known = {setting.variable for setting in settings_of()}
    told = dict(line.split("=", 1) for line in unit["Environment"])
    assert set(told) <= known
    assert {value.removeprefix("%d/") for value in told.values()} == copies
    environment = {name: value.replace("%d", "/run/credentials/x") for name, value in told.items()}
    settings = configure(["--config", str(PACKAGING / "gateway.toml")], environment).settings
    assert settings.tls_key == Path("/run/credentials/x/tls.key")
    assert settings.auth_keys == (Path("/run/credentials/x/tokens.pem"),)
