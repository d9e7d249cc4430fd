"""The settings of a gateway, and those that are refused, with a sentence."""

from pathlib import Path
from typing import Any

import pytest

from openrois.auth.loopback import is_loopback
from openrois.gateway.settings import GatewaySettings


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "127.9.8.7", "::1"])
def test_this_machine(host: str) -> None:
    assert is_loopback(host)
    assert GatewaySettings(host=host).host == host


@pytest.mark.parametrize(
    "host", ["", "0.0.0.0", "::", "192.168.0.1", "example.org", "localhost.example.org", "127.1", "127.0.0.1.nip.io"]
)
def test_not_this_machine(host: str) -> None:
    assert not is_loopback(host)
    with pytest.raises(ValueError, match="loopback"):
        GatewaySettings(host=host)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"port": -1}, "--port must be between 0 and 65535, not -1"),
        ({"port": 65536}, "not 65536"),
        ({"engine_id": ""}, "--engine-id '' is not valid"),
        ({"engine_id": "a/b"}, "--engine-id 'a/b' is not valid"),
        ({"ice_servers": ("stun.example.org",)}, "STUN"),
        ({"ice_servers": ("turn:x",)}, "STUN"),
        ({"ice_servers": ("stun:" + "x" * 512,)}, "STUN"),
        ({"ice_servers": ("stuns:stun.example.org",)}, "STUN"),
        ({"turn": ("stun:x",), "turn_secret": "s" * 16}, "no TURN address"),
        ({"turn": ("turn:x y",), "turn_secret": "s" * 16}, "no TURN address"),
        ({"turn": ("turn:x",)}, "given together"),
        ({"turn_secret": "s" * 16}, "given together"),
        ({"turn": ("turn:x",), "turn_secret": "short"}, "at least 16 characters"),
        ({"turn_ttl": 59}, "--turn-ttl must be between 60 and 86400 seconds, not 59"),
        ({"turn_ttl": 86401}, "not 86401"),
        ({"ranks": "person,person"}, "--ranks 'person,person' cannot be used: a rank is named twice"),
        ({"ranks": ""}, "--ranks '' cannot be used: '' is no rank"),
        ({"adapter_timeout": 0}, "--adapter-timeout must be more than 0 and less than 3600 seconds, not 0"),
        ({"adapter_timeout": float("nan")}, "finite"),
        ({"adapter_timeout": float("inf")}, "finite"),
    ],
)
def test_what_is_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        GatewaySettings(**settings)


def test_what_is_fine() -> None:
    settings = GatewaySettings(
        port=0, engine_id="fleet", ice_servers=("stun:stun.example.org:3478",), adapter_timeout=1
    )
    assert settings.port == 0
    relayed = GatewaySettings(turn=("turn:t", "turns:t:443?transport=tcp"), turn_secret="correct horse battery")
    assert "correct horse" not in repr(relayed)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.1", "gateway.example.org"])
def test_a_gateway_for_other_machines_needs_tokens_and_tls(host: str) -> None:
    key, cert = Path("key"), Path("cert")
    for settings, words in (
        ({}, "needs authentication"),
        ({"tls_cert": cert, "tls_key": key}, "needs authentication"),
        ({"auth_keys": (key,)}, "needs TLS"),
        ({"auth_jwks": "https://issuer.example/jwks"}, "needs TLS"),
    ):
        with pytest.raises(ValueError, match=words):
            GatewaySettings(host=host, **settings)
    assert GatewaySettings(host=host, auth_keys=(key,), tls_cert=cert, tls_key=key).is_authenticated
    assert GatewaySettings(host=host, auth_jwks_file=key, tls_elsewhere=True).is_authenticated


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            {"auth_keys": (Path("a"),), "auth_jwks": "https://issuer.example/"},
            "give only one of --auth-key, --auth-jwks",
        ),
        ({"auth_local": True, "auth_jwks_file": Path("a")}, "--auth-local cannot be used with --auth-jwks"),
        ({"auth_local": True, "auth_keys": (Path("a"),), "auth_issuer": "x"}, "cannot be used with --auth-local"),
        (
            {"auth_local": True, "cluster": ("nats://a",), "store": "postgresql://a@b/c", "gateway_id": "a"},
            "--auth-local cannot be used with --cluster",
        ),
        ({"auth_local": True, "host": "192.0.2.1"}, "--auth-local, which asks for no token, is for this machine alone"),
        ({"auth_jwks": "http://issuer.example/"}, "give an https address"),
        ({"auth_jwks": "ftp://issuer.example/"}, "no https address"),
        ({"auth_issuer": "x"}, "require --auth-key or --auth-jwks"),
        ({"auth_revocations": Path("x")}, "require --auth-key or --auth-jwks"),
        ({"auth_max_lifetime": 59}, "--auth-max-lifetime must be between 60 and 86400 seconds, not 59"),
        ({"auth_max_lifetime": 86401}, "not 86401"),
        ({"allow_origins": ("https://app.example.org/",)}, "no origin"),
        ({"allow_origins": ("*",)}, "no origin"),
        ({"allow_origins": ("null",)}, "no origin"),
        ({"allow_hosts": ("https://app.example.org",)}, "no name of a host"),
        ({"allow_hosts": ("app.example.org:8765",)}, "no name of a host"),
        ({"allow_hosts": ("",)}, "no name of a host"),
        ({"tls_elsewhere": True}, "--tls-elsewhere needs authentication"),
        ({"tls_cert": Path("x")}, "given together"),
        ({"tls_key": Path("x")}, "given together"),
        (
            {"tls_cert": Path("x"), "tls_key": Path("y"), "tls_elsewhere": True},
            "give either --tls-elsewhere or --tls-cert",
        ),
    ],
)
def test_what_is_refused_of_access(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        GatewaySettings(**settings)


def test_names_of_hosts() -> None:
    assert GatewaySettings(allow_hosts=("Gateway.example.org", "[::1]", "10.0.0.7")).allow_hosts
