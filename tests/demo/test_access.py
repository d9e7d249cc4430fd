"""Access to a demo: consistent options, arguments of its gateway, and the tokens of its own programs."""

import argparse
import time
from pathlib import Path

import pytest
from openrois_demo.access import DemoAccess, add_access_options, demo_access

from openrois.auth.claims import ClaimRules
from openrois.auth.key_files import make_key_files, read_keys
from openrois.auth.keys import StoredKeys
from openrois.auth.principal import Principal, Role
from openrois.auth.tokens import TokenVerifier
from openrois.gateway.configuration import configure
from openrois.transport.credential_options import add_credential_options


def chosen(*arguments: str) -> DemoAccess:
    parser = argparse.ArgumentParser()
    add_credential_options(parser)
    add_access_options(parser)
    return demo_access(parser.parse_args(arguments))


async def whose(token: str, key: Path) -> Principal:
    return await TokenVerifier(StoredKeys(read_keys([key])), ClaimRules(), time.time).verify(token)


def test_a_demo_is_for_this_machine_alone_unless_it_is_told() -> None:
    access = chosen()
    assert (access.url("http", 9000), access.url("ws", 9000)) == ("http://127.0.0.1:9000/", "ws://127.0.0.1:9000/")
    settings = configure(access.gateway_arguments(), {}).settings
    assert (settings.host, settings.auth_local) == ("127.0.0.1", True)
    assert chosen("--host", "::1").url("http", 9000) == "http://[::1]:9000/"


@pytest.mark.parametrize("algorithm", ["HS256", "ES256"])
async def test_a_demo_for_other_machines(algorithm: str, tmp_path: Path) -> None:
    *_, public = make_key_files(tmp_path / "key", algorithm)
    tls = ("--tls-cert", str(tmp_path / "cert.pem"), "--tls-key", str(tmp_path / "cert.key"))
    access = chosen(
        "--host", "0.0.0.0", "--allow-host", "Avatar.example.org", "--auth-key", str(tmp_path / "key"), *tls
    )
    assert access.url("ws", 9000) == "wss://avatar.example.org:9000/"
    settings = configure(access.gateway_arguments(), {}).settings
    assert (settings.host, settings.allow_hosts) == ("0.0.0.0", ("avatar.example.org",))
    assert settings.tls_cert == tmp_path / "cert.pem"
    assert (settings.auth_keys, settings.auth_local) == ((public,), False)
    viewer = await whose(access.viewer_token(), public)
    assert (viewer.roles, viewer.is_application, viewer.sees("avatar/move")) == ({Role.VIEWER}, True, True)


async def test_each_adapter_gets_a_new_token_in_time(tmp_path: Path) -> None:
    make_key_files(tmp_path / "key", "HS256")
    access = chosen("--auth-key", str(tmp_path / "key"))
    waited: list[float] = []

    async def sleep(seconds: float) -> None:
        waited.append(seconds)
        if len(waited) > 1:
            raise TimeoutError

    def secret(path: Path) -> str:
        assert path.stat().st_mode & 0o077 == 0
        return path.read_text().strip()

    async def read(path: Path) -> Principal:
        return await whose(secret(path), tmp_path / "key")

    with access.token_files(["avatar", "robot"]) as paths:
        first = {engine_id: await read(path) for engine_id, path in paths.items()}
        assert [each.subject for each in first.values()] == ["demo-avatar", "demo-robot"]
        assert {frozenset(each.roles) for each in first.values()} == {frozenset({Role.ADAPTER})}
        assert first["robot"].sees("robot/move")
        assert not first["robot"].sees("avatar/move"), "it cannot stand in for the other one"
        with pytest.raises(TimeoutError):
            await access.keep_tokens(paths, sleep)
        for engine_id, path in paths.items():
            second, expires = await read(path), first[engine_id].expires
            assert second.token_id != first[engine_id].token_id
            assert expires is not None
            assert waited[0] < expires - time.time()
    assert not paths["robot"].parent.exists()


async def test_without_authentication_there_are_no_tokens() -> None:
    with chosen().token_files(["avatar"]) as paths:
        assert paths == {}
        await chosen().keep_tokens(paths)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--tls-cert", "x"], "given together"),
        (["--host", "192.0.2.1", "--auth-key", "KEY"], "can be reached from other machines"),
        (["--host", "192.0.2.1", "--tls-cert", "x", "--tls-key", "x"], "can be reached from other machines"),
        (["--host", "::", "--tls-cert", "x", "--tls-key", "x", "--auth-key", "KEY"], "every address"),
        (["--auth-key", "KEY", "--token-file", "x"], "--token-file cannot be used with --auth-key"),
        (["--auth-key", "nothing"], "nothing cannot be read"),
    ],
)
def test_contradicting_options_are_refused(arguments: list[str], words: str, tmp_path: Path) -> None:
    make_key_files(tmp_path / "key", "HS256")
    with pytest.raises(ValueError, match=words):
        chosen(*(argument.replace("KEY", str(tmp_path / "key")) for argument in arguments))
