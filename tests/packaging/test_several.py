"""What is shipped for several gateways: units, compose file, haproxy and NATS fit each other and the gateway."""

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any, Final
from urllib.parse import urlsplit

import pytest
import yaml

from openrois.gateway.configuration import configure
from openrois.gateway.connection_limits import MAX_PER_ADDRESS
from openrois.gateway.settings import GatewaySettings
from tests.packaging.test_container import steps
from tests.packaging.test_service import entries
from tests.support.nats_program import nats_program
from tests.support.packages import ROOT

PACKAGING: Final = ROOT / "packaging"
ALONE: Final = PACKAGING / "openrois-gateway.service"
ONE_OF: Final = PACKAGING / "openrois-gateway@.service"
HAPROXY: Final = (PACKAGING / "haproxy.cfg").read_text(encoding="utf-8")
COMPOSE: Final[dict[str, Any]] = yaml.safe_load((PACKAGING / "compose.yml").read_text(encoding="utf-8"))
SERVICES: Final[dict[str, dict[str, Any]]] = COMPOSE["services"]
PAGE: Final = (ROOT / "docs/how-to/several-gateways.md").read_text(encoding="utf-8")
GATEWAYS: Final = ("gateway-a", "gateway-b", "gateway-c")
KNOWN: Final = {
    "command": list,
    "cap_drop": list,
    "depends_on": dict,
    "environment": dict,
    "extra_hosts": list,
    "healthcheck": dict,
    "image": str,
    "mem_limit": str,
    "networks": dict,
    "ports": list,
    "read_only": bool,
    "restart": str,
    "secrets": list,
    "security_opt": list,
    "shm_size": str,
    "stop_grace_period": str,
    "tmpfs": list,
    "ulimits": dict,
    "user": str,
    "volumes": list,
}
"""What may stand in a service of the compose file, of what the Compose Specification knows."""


def configured(words: list[str], environment: dict[str, str]) -> GatewaySettings:
    """Return the settings of a gateway with a command line and variables, where its file is the one that is shipped."""
    words = [str(PACKAGING / "cluster.toml") if each == "/etc/openrois/cluster.toml" else each for each in words]
    return configure(words, environment).settings


def of_unit(gateway_id: str) -> GatewaySettings:
    """Return the settings of a gateway that its unit starts."""
    line = entries(ONE_OF)["ExecStart"][0].replace("%i", gateway_id).replace("%S", "/var/lib")
    program, name, *words = line.replace("${CREDENTIALS_DIRECTORY}", "/run/credentials").split()
    assert (program, name) == ("/opt/openrois/bin/openrois", "gateway")
    return configured(words, {})


def of_service(name: str) -> GatewaySettings:
    """Return the settings of a gateway that the compose file starts."""
    words: list[str] = json.loads(dict(steps())["ENTRYPOINT"]) + SERVICES[name]["command"]
    assert words[:2] == ["/opt/openrois/bin/openrois", "gateway"]
    return configured(words[2:], SERVICES[name]["environment"])


def mounted(name: str) -> dict[str, str]:
    """Return what a service finds at which path: a named volume, or a path beside the compose file."""
    found = {}
    for entry in SERVICES[name].get("volumes", ()):
        source, target, *mode = entry.split(":")
        assert mode == (["ro"] if source.startswith("./") else []), entry
        found[target] = source
    return found


def published(name: str) -> tuple[int, int]:
    """Return the port of a service at its host, and in its container."""
    (entry,) = SERVICES[name]["ports"]
    outside, _, inside = entry.partition(":")
    return int(outside), int(inside)


def servers() -> Iterator[tuple[str, str, str, int]]:
    """Return backend, name, host and port of each gateway that haproxy knows."""
    for section in re.split(r"^(?=\w)", HAPROXY, flags=re.MULTILINE):
        for name, host, port in re.findall(r"^    server (\w+) ([\w.-]+):(\d+)$", section, re.MULTILINE):
            yield section.split()[1], name, host, int(port)


# The units.


def test_one_of_several_is_kept_as_close_as_one_on_its_own() -> None:
    alone, one_of = entries(ALONE), entries(ONE_OF)
    own = {"Description", "After", "ExecStart", "RestartSec", "StateDirectory"}
    only = {"EnvironmentFile", "LoadCredential", "StartLimitBurst"}
    assert {key for key in {*alone, *one_of} if alone.get(key) != one_of.get(key)} == own | only | {
        "StartLimitIntervalSec"
    }
    # While PostgreSQL is away it does not start, and is not given up.
    assert one_of["StartLimitIntervalSec"] == ["0"]
    assert int(one_of["TimeoutStopSec"][0]) > of_unit("a").drain


def test_gateways_of_the_unit_have_what_is_shared_and_what_is_their_own() -> None:
    settings = {each: of_unit(each) for each in "abc"}
    for gateway_id, each in settings.items():
        assert each.gateway_id == gateway_id
        assert each.audit_file is not None
        assert str(each.audit_file.parent) == f"/var/lib/{entries(ONE_OF)['StateDirectory'][0]}".replace(
            "%i", gateway_id
        )
        assert each.is_authenticated
        assert each.tls_cert is not None
    own = {"gateway_id": None, "audit_file": None}
    assert settings["a"].model_copy(update=own) == settings["b"].model_copy(update=own)


def test_secrets_of_the_unit_are_credentials_that_root_alone_reads() -> None:
    loaded = dict(each.split(":") for each in entries(ONE_OF)["LoadCredential"])
    settings = of_unit("a")
    assert {str(settings.store_password), str(settings.cluster_credentials)} == {
        f"/run/credentials/{name}" for name in loaded
    }
    for name, path in loaded.items():
        assert path == f"/etc/openrois/{name}"
    assert {Path(path).name for path in loaded.values()} == set(COMPOSE["secrets"])


def test_what_gateways_share_is_encrypted_on_its_way() -> None:
    settings = of_unit("a")
    assert all(each.startswith("tls://") for each in settings.cluster)
    # Without an sslmode a server elsewhere is asked for a certificate that can be verified.
    assert "sslmode" not in settings.store


# The compose file.


def test_the_compose_file_says_what_can_be_said() -> None:
    assert set(COMPOSE) == {"name", "x-gateway", "x-environment", "services", "networks", "volumes", "secrets"}
    for service in SERVICES.values():
        assert {key: type(value) for key, value in service.items()} == {key: KNOWN[key] for key in service}
        assert set(service["healthcheck"]) <= {"test", "interval", "timeout", "start_period"}
        assert service["healthcheck"]["test"][0] == "CMD"
        assert set(service.get("depends_on", ())) <= set(SERVICES)
    used = {each for service in SERVICES.values() for each in service.get("secrets", ())}
    assert used == set(COMPOSE["secrets"])
    volumes = {each for name in SERVICES for each in mounted(name).values() if not each.startswith("./")}
    assert volumes == set(COMPOSE["volumes"])


def test_every_service_comes_back_and_can_do_little() -> None:
    for name, service in SERVICES.items():
        assert service["restart"] == "unless-stopped"
        assert service["security_opt"] == ["no-new-privileges:true"]
        assert service["mem_limit"]
        # PostgreSQL's image begins as root, which makes its folder.
        assert (service.get("read_only"), service.get("cap_drop")) == (
            (None, None) if name == "postgres" else (True, ["ALL"])
        )
    unit = entries(ONE_OF)
    for name in GATEWAYS:
        assert f"{unit['MemoryMax'][0]}".lower() == SERVICES[name]["mem_limit"]
        assert int(unit["LimitNOFILE"][0]) == SERVICES[name]["ulimits"]["nofile"]
        assert int(SERVICES[name]["stop_grace_period"].removesuffix("s")) > of_service(name).drain


def test_images_are_of_the_version_that_was_tried() -> None:
    images = {service["image"] for service in SERVICES.values()}
    library = "docker.io/library"
    assert images == {
        "openrois-gateway",
        f"{library}/haproxy:2.6",
        f"{library}/nats:2-alpine",
        f"{library}/postgres:15",
    }


def test_gateways_of_the_compose_file_have_what_is_shared_and_what_is_their_own() -> None:
    settings = {name: of_service(name) for name in GATEWAYS}
    assert len({mounted(name)["/var/lib/openrois"] for name in GATEWAYS}) == len(GATEWAYS)
    for name, each in settings.items():
        assert each.gateway_id == name.removeprefix("gateway-")
        assert mounted(name)["/etc/openrois"] == "./etc"
        assert str(each.audit_file) == "/var/lib/openrois/audit.jsonl"
        assert published(name)[1] == each.port
        assert SERVICES[name]["healthcheck"]["test"][1:] == json.loads(
            dict(steps())["HEALTHCHECK"].partition("CMD ")[2]
        )
    own = {"gateway_id": None}
    assert len({str(each.model_copy(update=own)) for each in settings.values()}) == 1
    outside = [published(name)[0] for name in (*GATEWAYS, "haproxy")]
    assert len(set(outside)) == len(outside)


def test_gateways_of_the_compose_file_find_postgresql() -> None:
    settings, environment = of_service("gateway-a"), SERVICES["postgres"]["environment"]
    store = urlsplit(settings.store)
    assert (store.hostname, store.username, store.path) == (
        "postgres",
        environment["POSTGRES_USER"],
        f"/{environment['POSTGRES_DB']}",
    )
    assert str(settings.store_password) == environment["POSTGRES_PASSWORD_FILE"]
    assert {
        PurePosixPath(each).name for each in (str(settings.store_password), str(settings.cluster_credentials))
    } == set(SERVICES["gateway-a"]["secrets"])
    assert SERVICES["postgres"]["healthcheck"]["test"][-4:] == ["-U", store.username, "-d", store.path[1:]]


def test_gateways_of_the_compose_file_find_nats() -> None:
    (url,) = of_service("gateway-a").cluster
    text = (PACKAGING / "nats.conf").read_text(encoding="utf-8")
    address = urlsplit(url)
    assert address.hostname in SERVICES
    assert re.findall(r"^port: (\d+)$", text, re.MULTILINE) == [str(address.port)]
    (config,) = [word for word in SERVICES["nats"]["command"] if word.startswith("/")]
    assert mounted("nats")[config] == "./etc/nats.conf"
    (included,) = re.findall(r'include "(.+)"', text)
    assert mounted("nats")[str(PurePosixPath(config).with_name(included))] == f"./secrets/{included}"
    (probed,) = re.findall(r'^http: "(.+)"$', text, re.MULTILINE)
    assert SERVICES["nats"]["healthcheck"]["test"][-1] == f"http://{probed}/healthz"


@pytest.mark.usefixtures("nats")
def test_nats_takes_its_configuration_and_the_token_as_it_is_made(tmp_path: Path) -> None:
    shutil.copy(PACKAGING / "nats.conf", tmp_path)
    (tmp_path / "nats-token.conf").write_text('token: "0123456789abcdef"\n')
    words = [str(nats_program()), "-t", "-c", str(tmp_path / "nats.conf")]
    said = subprocess.run(words, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stderr


# haproxy, in front of both.


def test_haproxy_knows_each_gateway_in_both_of_its_backends() -> None:
    found = sorted(servers())
    hosts = {name: (host, port) for backend, name, host, port in found if backend == "ready"}
    assert {name: (host, port) for backend, name, host, port in found if backend == "living"} == hosts
    assert len(found) == 2 * len(hosts)
    settings = of_unit("a")
    for name, (host, port) in hosts.items():
        assert host in settings.allow_hosts
        assert host.startswith(f"gateway-{name}.")
        assert port == settings.port


def test_haproxy_of_the_compose_file_knows_gateways_that_are_away() -> None:
    addresses = dict(each.split(":") for each in SERVICES["haproxy"]["extra_hosts"])
    networks = {name: SERVICES[name]["networks"]["default"]["ipv4_address"] for name in GATEWAYS}
    assert addresses == {f"{name}.example.org": address for name, address in networks.items()}
    assert set(addresses) == {host for _, _, host, _ in servers()}
    (network,) = COMPOSE["networks"]["default"]["ipam"]["config"]
    assert all(address.startswith(network["subnet"].removesuffix("0/24")) for address in addresses.values())
    (bound,) = re.findall(r"^    bind :(\d+)$", HAPROXY, re.MULTILINE)
    assert published("haproxy") == (int(bound), int(bound))
    assert SERVICES["haproxy"]["healthcheck"]["test"][-1].endswith(f"/{bound}")
    assert "./etc/haproxy.cfg" in mounted("haproxy").values()


def test_the_limit_of_an_address_is_that_of_a_gateway_on_its_own() -> None:
    assert re.findall(r"sc_conn_cur\(0\) gt (\d+)", HAPROXY) == [str(MAX_PER_ADDRESS)]
    settings = of_unit("a")
    assert settings.per_address == settings.most_applications
    assert settings.silent_per_address == settings.silent


# The page.


def installed(pattern: str) -> set[str]:
    """Return the names of the files that a step of the page installs."""
    (found,) = re.findall(pattern, PAGE, re.MULTILINE)
    return {Path(each).name for each in found.split()}


def test_who_makes_services_installs_all_that_they_read() -> None:
    settings = of_unit("a")
    read = [*settings.auth_keys, settings.tls_cert, settings.tls_key]
    shared = {path.name for path in read if path is not None}
    assert installed(r"^    install -m 0640 -g openrois (.*) /etc/openrois/$") == shared | {"cluster.toml"}
    assert installed(r"^    install -m 0600 (.*) /etc/openrois/$") == set(COMPOSE["secrets"])
    assert installed(r"^    install -m 0644 (packaging/openrois\S+) /etc/systemd/system/$") == {ONE_OF.name}
    names = re.findall(r"^    (OPENROIS_GATEWAY_\w+)=(.*)$", PAGE, re.MULTILINE)
    assert configure([], dict(names)).settings.port != settings.port


def test_who_makes_containers_puts_all_that_they_read_beside_their_file() -> None:
    settings = of_service("gateway-a")
    read = [*settings.auth_keys, settings.tls_cert, settings.tls_key]
    files = {each.name for each in read if each is not None} | {"cluster.toml"}
    files |= {Path(each).name for name in SERVICES for each in mounted(name).values() if each.startswith("./etc/")}
    steps = [r"^    install -D -m 0644 -t etc (.*)$", r"^    install -m 0400 -o 10001 (.*) etc/$"]
    assert {name for each in steps for name in installed(each)} == files
    secrets = {Path(each["file"]).name for each in COMPOSE["secrets"].values()}
    secrets |= {Path(each).name for each in mounted("nats").values() if each.startswith("./secrets/")}
    assert set(re.findall(r"> secrets/(\S+)", PAGE)) == secrets
