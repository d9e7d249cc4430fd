"""Where NATS is and what is shown to it; no secret is repeated."""

import ssl
from pathlib import Path

import pytest

from openrois.cluster.settings import Login, NatsSettings
from tests.support.certificates import Authority

pytestmark = pytest.mark.extra(name="cluster")
SERVERS = ("nats://127.0.0.1:4222",)


@pytest.mark.parametrize(
    "server", ["nats://127.0.0.1:4222", "tls://nats.example:4222", "nats://[::1]:4222/", "nats://a"]
)
def test_addresses(server: str) -> None:
    assert NatsSettings((server,)).servers == (server,)


@pytest.mark.parametrize(
    "server",
    ["", "127.0.0.1", "ws://127.0.0.1", "nats://", "nats://a:99999", "nats://a:0", "nats://a/b", "nats://[::1"],
)
def test_what_is_no_address_is_said(server: str) -> None:
    with pytest.raises(ValueError, match="is no address of a NATS server, such as nats://"):
        NatsSettings((server,))


def test_secrets_do_not_belong_in_an_address() -> None:
    with pytest.raises(ValueError, match="name a file") as raised:
        NatsSettings(("nats://alice:canary@127.0.0.1",))
    assert "canary" not in str(raised.value)


def test_what_is_missing_is_said() -> None:
    with pytest.raises(ValueError, match="no server of NATS is named"):
        NatsSettings(())
    with pytest.raises(ValueError, match="no use without its certificate"):
        NatsSettings(SERVERS, key_file=Path("key.pem"))
    with pytest.raises(ValueError, match="1 to 128 bytes"):
        NatsSettings(SERVERS, prefix="")


@pytest.mark.parametrize(
    ("text", "login"),
    [("canary\n", Login(token="canary")), ("alice\ncanary\n", Login("alice", "canary")), ("a\r\nb", Login("a", "b"))],
)
def test_credentials_are_read_at_each_use(text: str, login: Login, tmp_path: Path) -> None:
    path = tmp_path / "credentials"
    named = NatsSettings(SERVERS, credentials_file=path)
    path.write_text("before")
    assert named.login() == Login(token="before")
    path.write_text(text)
    assert named.login() == login
    assert "canary" not in repr(named.login())
    assert NatsSettings(SERVERS).login() is None


@pytest.mark.parametrize("content", [b"", b"\n", b"one\ntwo\ncanary", b"canary\xff"])
def test_what_holds_no_credentials_is_said_without_what_it_holds(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "credentials"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="holds no credentials for NATS") as raised:
        NatsSettings(SERVERS, credentials_file=path).login()
    assert "canary" not in str(raised.value)
    with pytest.raises(ValueError, match="cannot be read"):
        NatsSettings(SERVERS, credentials_file=tmp_path / "nothing").login()


def test_files_for_tls(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    certificate, key = authority.issue()
    named = NatsSettings(SERVERS, ca_file=authority.file, certificate_file=certificate, key_file=key)
    assert named.names_tls
    context = named.context()
    assert context.verify_mode is ssl.CERT_REQUIRED
    assert context.check_hostname
    assert len(context.get_ca_certs()) == 1
    assert not NatsSettings(SERVERS).names_tls


def test_files_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    certificate, key = authority.issue(password=b"secret")
    with pytest.raises(ValueError, match=r"nothing\.pem cannot be used for TLS with NATS: No such file"):
        NatsSettings(SERVERS, ca_file=tmp_path / "nothing.pem").context()
    with pytest.raises(ValueError, match=r"cert\.pem cannot be used for TLS with NATS"):
        NatsSettings(SERVERS, certificate_file=certificate, key_file=key).context()
