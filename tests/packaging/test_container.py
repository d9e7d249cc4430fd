"""The container file, as far as it can be tried without an image to build on: what it copies, runs and starts."""

import json
import shlex
import subprocess
import sys
import tomllib

from openrois.extras import EXTRAS
from openrois.gateway import probe
from openrois.gateway.configuration import configure
from openrois.gateway.settings import GatewaySettings
from tests.support.packages import ROOT, tracked

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
    known = {
        "ARG",
        "FROM",
        "HEALTHCHECK",
        "WORKDIR",
        "COPY",
        "RUN",
        "USER",
        "ENV",
        "VOLUME",
        "EXPOSE",
        "STOPSIGNAL",
        "ENTRYPOINT",
        "CMD",
    }
    assert {name for name, _ in steps()} == known


def test_what_it_copies_is_there_and_is_all_that_the_build_reads() -> None:
    for source in copied():
        assert any(name == source or name.startswith(f"{source}/") for name in tracked()), source
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    hatch = project["tool"]["hatch"]
    wheel = hatch["build"]["targets"]["wheel"]
    needed = [*wheel["packages"], hatch["build"]["hooks"]["custom"]["path"], *project["project"]["license-files"]]
    needed += ["README.md", hatch["version"]["path"], "avatar_adapter/godot"]
    for path in ("pyproject.toml", "constraints.txt", *needed):
        assert any(path == source or path.startswith(f"{source}/") for source in copied()), path


def test_it_installs_what_was_tried_and_nothing_newer() -> None:
    (install,) = [rest for name, rest in steps() if name == "RUN" and "pip install" in rest]
    words = shlex.split(install)
    assert words[words.index("-c") + 1] == "constraints.txt"
    assert words[-1] == ".[cluster]"


def test_another_image_may_be_built_on() -> None:
    (base,) = [rest for name, rest in steps() if name == "ARG"]
    assert base.startswith("BASE=docker.io/library/python:3.")
    assert [rest.split()[0] for name, rest in steps() if name == "FROM"] == ["${BASE}", "${BASE}"]


def test_the_builder_is_given_what_is_copied_and_not_the_rest() -> None:
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    rules = [line for line in lines if not line.startswith("#")]
    assert rules[0] == "*"
    assert {rule.removeprefix("!") for rule in rules if rule.startswith("!")} == set(copied())
    assert [rule for rule in rules[1:] if not rule.startswith("!")] == ["**/__pycache__"]


def test_a_gateway_needs_nothing_that_is_not_in_it() -> None:
    (removed,) = [rest for name, rest in steps() if name == "RUN" and "pip uninstall" in rest]
    gone = removed.partition("--yes ")[2].split()
    others = {module for modules in EXTRAS.values() for module in modules} - set(EXTRAS["cluster"])
    modules = sorted({*gone, *others})
    program = (
        f"import sys; sys.modules.update(dict.fromkeys({modules!r}))\n"
        "import openrois.gateway.command, openrois.auth.command, openrois_conformance.command, openrois.cli.__main__\n"
        "import openrois.gateway.cluster_parts, openrois_demo.doctor.command, openrois_demo.doctor.cluster"
    )
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=True)


def test_its_health_is_asked_where_it_listens() -> None:
    words: list[str] = json.loads(dict(steps())["HEALTHCHECK"].partition("CMD ")[2])
    assert words == ["/opt/openrois/bin/python3", "-m", probe.__name__]
    settings = configure(["--config", str(PACKAGING / "gateway.toml")], {}).settings
    assert settings.tls_cert is not None
    assert f"https://127.0.0.1:{settings.port}/healthz" == probe.DEFAULT


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
