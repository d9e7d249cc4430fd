"""Access to a demo: consistent options, arguments of its gateway, and the tokens of its own programs."""

import argparse
import time
from pathlib import Path

import pytest
from openrois_demo.access import DemoAccess, add_access_options, demo_access
from openrois_demo.tokens import DemoTokens

from openrois.auth.claims import ClaimRules
from openrois.auth.key_files import make_key_files, read_keys
from openrois.auth.keys import StoredKeys
from openrois.auth.principal import Principal, Role
from openrois.auth.ranks import DEFAULT_RANKS
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
    with DemoTokens.issued(access.key, ["avatar"]) as tokens:
        settings = configure(access.gateway_arguments(tokens.key), {}).settings
        assert (settings.host, settings.auth_local, settings.auth_keys) == ("127.0.0.1", True, (tokens.key,))
    assert chosen("--host", "::1").url("http", 9000) == "http://[::1]:9000/"


@pytest.mark.parametrize("algorithm", ["HS256", "ES256"])
async def test_a_demo_for_other_machines(algorithm: str, tmp_path: Path) -> None:
    *_, public = make_key_files(tmp_path / "key", algorithm)
    tls = ("--tls-cert", str(tmp_path / "cert.pem"), "--tls-key", str(tmp_path / "cert.key"))
    access = chosen(
        "--host", "0.0.0.0", "--allow-host", "Avatar.example.org", "--auth-key", str(tmp_path / "key"), *tls
    )
    assert access.url("ws", 9000) == "wss://avatar.example.org:9000/"
    settings = configure(access.gateway_arguments(tmp_path / "key"), {}).settings
    assert (settings.host, settings.allow_hosts) == ("0.0.0.0", ("avatar.example.org",))
    assert settings.tls_cert == tmp_path / "cert.pem"
    assert (settings.auth_keys, settings.auth_local) == ((public,), False)
    with DemoTokens.issued(access.key, ["avatar"]) as tokens:
        viewer = await whose(tokens.viewer(), public)
    assert (viewer.roles, viewer.is_application, viewer.sees("avatar/move")) == ({Role.VIEWER}, True, True)


async def test_each_adapter_gets_a_new_token_in_time(tmp_path: Path) -> None:
    make_key_files(tmp_path / "key", "HS256")
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

    with DemoTokens.issued(tmp_path / "key", ["avatar", "robot"]) as tokens:
        paths = tokens.adapters
        first = {engine_id: await read(path) for engine_id, path in paths.items()}
        assert [each.subject for each in first.values()] == ["demo-avatar", "demo-robot"]
        assert {frozenset(each.roles) for each in first.values()} == {frozenset({Role.ADAPTER})}
        assert first["robot"].sees("robot/move")
        assert not first["robot"].sees("avatar/move"), "it cannot stand in for the other one"
        with pytest.raises(TimeoutError):
            await tokens.keep(sleep)
        for engine_id, path in paths.items():
            second, expires = await read(path), first[engine_id].expires
            assert second.token_id != first[engine_id].token_id
            assert expires is not None
            assert waited[0] < expires - time.time()
    assert not paths["robot"].parent.exists()


@pytest.mark.parametrize("has_key", [False, True], ids=["of this machine", "with a key"])
async def test_programs_find_a_token_of_each_rank_below_that_of_people(tmp_path: Path, has_key: bool) -> None:
    make_key_files(tmp_path / "key", "HS256")
    with DemoTokens.issued(tmp_path / "key" if has_key else None, ["avatar"]) as tokens:
        assert set(tokens.adapters) == ({"avatar"} if has_key else set())
        assert set(tokens.programs) == set(DEFAULT_RANKS[1:])
        for rank, path in tokens.programs.items():
            assert (path.stat().st_mode & 0o077, path.parent.stat().st_mode & 0o077) == (0, 0)
            found = await whose(path.read_text().strip(), tokens.key)
            assert (found.subject, found.rank, found.sees("avatar/move")) == (rank, rank, True)
            assert {Role.OPERATOR} <= found.roles
            assert not {Role.ADMINISTRATOR, Role.ADAPTER} & found.roles


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
