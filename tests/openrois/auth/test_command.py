"""`openrois token`: keys are made once, tokens are good, and what no gateway would take is not issued."""

import stat
import time
from pathlib import Path

import pytest

from openrois.auth.claims import ClaimRules
from openrois.auth.command import main
from openrois.auth.key_files import read_keys
from openrois.auth.keys import ALGORITHMS, StoredKeys
from openrois.auth.principal import Role
from openrois.auth.tokens import TokenVerifier

pytestmark = pytest.mark.extra(name="gateway")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
async def test_a_token_of_a_new_key(algorithm: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    key = tmp_path / "key"
    assert main(["new-key", str(key), "--algorithm", algorithm]) == 0
    *_, public = [Path(line) for line in capsys.readouterr().out.split()]
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    options = ["--sub", "alice", "--role", "operator", "--role", "viewer", "--scope", "avatar/*", "--ttl", "15m"]
    assert main(["issue", "--key", str(key), *options, "--issuer", "us", "--audience", "gateway"]) == 0
    token = capsys.readouterr().out.strip()
    verifier = TokenVerifier(StoredKeys(read_keys([public])), ClaimRules("us", "gateway"), time.time)
    principal = await verifier.verify(token)
    assert (principal.subject, principal.roles) == ("alice", {Role.OPERATOR, Role.VIEWER})
    assert principal.scope == ("avatar/*",)
    assert principal.token_id
    assert principal.expires is not None
    assert 890 < principal.expires - time.time() <= 900


async def test_an_administrator_needs_no_scope(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    key = tmp_path / "key"
    assert main(["new-key", str(key)]) == 0
    capsys.readouterr()
    for role, scope in (("administrator", ("*",)), ("viewer", ())):
        assert main(["issue", "--key", str(key), "--sub", "root", "--role", role]) == 0
        verifier = TokenVerifier(StoredKeys(read_keys([key])), ClaimRules(), time.time)
        assert (await verifier.verify(capsys.readouterr().out.strip())).scope == scope


def test_a_key_is_never_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    key = tmp_path / "key"
    assert main(["new-key", str(key)]) == 0
    text = key.read_text()
    assert main(["new-key", str(key)]) == 1
    assert f"{key} exists already" in capsys.readouterr().err
    assert key.read_text() == text


async def test_a_token_of_a_person(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    key = tmp_path / "key"
    assert main(["new-key", str(key)]) == 0
    capsys.readouterr()
    assert main(["issue", "--key", str(key), "--sub", "ann", "--role", "operator", "--rank", "person"]) == 0
    verifier = TokenVerifier(StoredKeys(read_keys([key])), ClaimRules(), time.time)
    assert (await verifier.verify(capsys.readouterr().out.strip())).rank == "person"


@pytest.mark.parametrize(
    "options",
    [
        ["--sub", "a", "--role", "viewer", "--rank", "person "],
        ["--sub", "", "--role", "viewer"],
        ["--sub", "a", "--role", "viewer", "--scope", ""],
        ["--sub", "a\nb", "--role", "viewer"],
    ],
)
def test_what_is_not_issued(options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    key = tmp_path / "key"
    main(["new-key", str(key)])
    assert main(["issue", "--key", str(key), *options]) == 1
    told = "is no rank" if "--rank" in options else "a gateway would refuse this token: --sub must have 1 to 128"
    assert told in capsys.readouterr().err
    assert main(["issue", "--key", str(tmp_path / "none"), "--sub", "a", "--role", "viewer"]) == 1
    assert "cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize("ttl", ["0", "-1", "1w", "", "15 m", "1.5h"])
def test_what_is_no_time(ttl: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["issue", "--key", "x", "--sub", "a", "--role", "viewer", f"--ttl={ttl}"])
    assert "is no duration" in capsys.readouterr().err


@pytest.mark.parametrize("ttl", ["2d", "25h", "999999d"])
def test_what_no_gateway_would_take_for_so_long(ttl: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["issue", "--key", "x", "--sub", "a", "--role", "viewer", "--ttl", ttl])
    assert "a token may last for a day at most" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--role", "viewer"], "without --scope this token is good for no component"),
        (["--role", "viewer", "--scope", "*", "--ttl", "2h"], "only with --auth-max-lifetime 7200 or more"),
        (["--role", "viewer", "--scope", "*", "--rank", "crew"], "only where its --ranks name crew"),
        (["--role", "viewer", "--scope", "*", "--ttl", "1h"], ""),
        (["--role", "administrator"], ""),
    ],
)
def test_what_a_token_is_no_good_for_is_said_beside_it(
    options: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key = tmp_path / "key"
    main(["new-key", str(key)])
    capsys.readouterr()
    assert main(["issue", "--key", str(key), "--sub", "a", *options]) == 0
    shown = capsys.readouterr()
    assert shown.out.count("\n") == 1
    assert (words in shown.err) if words else not shown.err


def test_a_public_key_is_no_secret(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    key = tmp_path / "key"
    main(["new-key", str(key), "--algorithm", "ES256"])
    assert main(["issue", "--key", f"{key}.pub", "--sub", "a", "--role", "viewer"]) == 1
    assert "a public key cannot sign" in capsys.readouterr().err
    assert not caplog.text
