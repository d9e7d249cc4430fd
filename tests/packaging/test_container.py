"""The container file, as far as it can be tried without an image to build on: what it copies, runs and starts."""

import json
import shlex
import subprocess
import tomllib
from pathlib import Path

from openrois.gateway.configuration import configure
from openrois.gateway.settings import GatewaySettings

ROOT = Path(__file__).parents[2]
PACKAGING = ROOT / "packaging"


def steps() -> list[tuple[str, str]]:
    """Return the instructions of the container file, each with the rest of its line."""
    lines = (PACKAGING / "Containerfile").read_text(encoding="utf-8").splitlines()
    return [(line.partition(" ")[0], line.partition(" ")[2]) for line in lines if line and not line.startswith("#")]


def copied() -> list[str]:
    """Return what is copied out of the repository."""
    words = [rest.split() for name, rest in steps() if name == "COPY" and not rest.startswith("--from")]
    return [source for line in words for source in line[:-1]]


def test_it_knows_only_what_a_container_file_may_say() -> None:
    known = {"FROM", "WORKDIR", "COPY", "RUN", "USER", "ENV", "VOLUME", "EXPOSE", "STOPSIGNAL", "ENTRYPOINT", "CMD"}
    assert {name for name, _ in steps()} == known


def test_what_it_copies_is_there_and_is_all_that_the_build_reads() -> None:
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    for source in copied():
        assert any(name == source or name.startswith(f"{source}/") for name in tracked), source
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = [*wheel["packages"], wheel["hooks"]["custom"]["path"], *project["project"]["license-files"]]
    needed += [project["project"]["readme"], project["tool"]["hatch"]["version"]["path"], "avatar_adapter/godot"]
    for path in ("pyproject.toml", "constraints.txt", *needed):
        assert any(path == source or path.startswith(f"{source}/") for source in copied()), path


def test_it_installs_what_was_tried_and_nothing_newer() -> None:
    (install,) = [rest for name, rest in steps() if name == "RUN" and "pip install" in rest]
    words = shlex.split(install)
    assert words[words.index("-c") + 1] == "constraints.txt"
    assert words[-1] == "."


def test_nobody_in_it_is_root() -> None:
    last = dict(steps())
    user, _, group = last["USER"].partition(":")
    assert user.isdecimal()
    assert group.isdecimal()
    assert 0 not in (int(user), int(group))
    order = [name for name, _ in steps()]
    assert order.index("USER") > max(number for number, name in enumerate(order) if name == "RUN")
    assert last["STOPSIGNAL"] == "SIGTERM"


def test_it_starts_a_gateway_with_the_configuration_that_is_shipped() -> None:
    last = dict(steps())
    words: list[str] = json.loads(last["ENTRYPOINT"]) + json.loads(last["CMD"])
    assert words == ["/opt/openrois/bin/openrois", "gateway", "--config", "/etc/openrois/gateway.toml"]
    settings = configure(["--config", str(PACKAGING / "gateway.toml")], {}).settings
    assert int(last["EXPOSE"]) == settings.port == GatewaySettings().port
    assert settings.is_authenticated
    assert settings.tls_cert is not None
    assert settings.audit_file is not None
    volumes = json.loads(last["VOLUME"])
    assert {str(path.parent) for path in (settings.audit_file, settings.journal) if path is not None} <= set(volumes)
