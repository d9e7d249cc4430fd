"""What is shown to a gateway: from files that are read when they are needed, and never said."""

import ssl
from pathlib import Path

import pytest

from openrois.transport.credentials import CA_FILE_VARIABLE, TOKEN_FILE_VARIABLE, Credentials, read_token
from tests.support.certificates import Authority


def test_a_token_is_read_at_each_use(tmp_path: Path) -> None:
    path = tmp_path / "token"
    path.write_text("first\n")
    credentials = Credentials.of_files(path, None)
    assert credentials.headers() == {"Authorization": "Bearer first"}
    path.write_text("second")
    assert credentials.headers() == {"Authorization": "Bearer second"}
    assert "second" not in repr(credentials)
    assert Credentials(path.read_text() + "\n").newest() == "second"
    assert Credentials("canary").headers() == {"Authorization": "Bearer canary"}
    assert "canary" not in repr(Credentials("canary"))
    assert Credentials().headers() == {}


def test_files_that_the_environment_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    authority = Authority(tmp_path)
    (tmp_path / "token").write_text("named")
    monkeypatch.setenv(TOKEN_FILE_VARIABLE, str(tmp_path / "token"))
    monkeypatch.setenv(CA_FILE_VARIABLE, str(authority.file))
    credentials = Credentials.of_files(None, None)
    assert credentials.newest() == "named"
    assert credentials.ca_file == authority.file


@pytest.mark.parametrize("content", [b"", b"\n", b"two words", b"a\nb", b"\xff"])
def test_what_is_no_token(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "token"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="there is no token in"):
        read_token(path)
    with pytest.raises(ValueError, match="cannot be read"):
        read_token(tmp_path / "nothing")


@pytest.mark.parametrize("given", ["", "canary two", "canary\ncanary", "canary\x00", "can\u2028ary", "canäry"])
def test_what_is_given_and_no_token(given: str) -> None:
    for token in (given, lambda: given):
        with pytest.raises(ValueError, match="there is no token in what was given as one") as raised:
            Credentials(token).headers()
        assert "can" not in str(raised.value)


def test_authorities(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    assert Credentials(ca_file=authority.file).context("ws://gateway/") is None
    context = Credentials(ca_file=authority.file).context("wss://gateway/")
    assert context is not None
    assert context.verify_mode is ssl.CERT_REQUIRED
    assert context.check_hostname
    assert context.minimum_version >= ssl.TLSVersion.TLSv1_2
    assert len(context.get_ca_certs()) == 1
    assert Credentials().context("wss://gateway/") is not None
    for path in (tmp_path / "nothing", tmp_path / "nonsense"):
        (tmp_path / "nonsense").write_text("nonsense")
        with pytest.raises(ValueError, match="cannot be used as authorities"):
            Credentials(ca_file=path).context("wss://gateway/")
