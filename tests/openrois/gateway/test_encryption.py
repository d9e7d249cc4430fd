"""TLS of the port: which versions, which certificates, and a new one while connections go on."""

import asyncio
import base64
import socket
import ssl
import textwrap
import time
import warnings
from pathlib import Path

import aiohttp
import pytest
from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, load_pem_private_key

from openrois.client import Client
from openrois.gateway.encryption import Certificate
from tests.support.certificates import Authority
from tests.support.guarded import Guarded, ask, fresh, guarded

VERSIONS = [ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1, ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3]


def context(authority: Authority, version: ssl.TLSVersion, ciphers: str = "") -> ssl.SSLContext:
    """Return a context of one version only; old ones are offered as far as the library still can."""
    made = authority.context()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        made.set_ciphers(ciphers or ("ALL:@SECLEVEL=0" if version < ssl.TLSVersion.TLSv1_2 else "DEFAULT"))
        made.minimum_version = made.maximum_version = version
    return made


async def served(coming: Guarded, how: ssl.SSLContext) -> int:
    async with aiohttp.ClientSession() as session, session.get(f"{coming.gateway.url}healthz", ssl=how) as response:
        return response.status


@pytest.mark.parametrize("version", VERSIONS, ids=lambda version: version.name)
async def test_versions(version: ssl.TLSVersion, tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        assert coming.gateway.url.startswith("https://")
        how = context(authority, version)
        if version >= ssl.TLSVersion.TLSv1_2:
            assert await served(coming, how) == 200
        else:
            with pytest.raises(aiohttp.ClientConnectorError):
                await served(coming, how)


@pytest.mark.parametrize(
    "ciphers", ["NULL-SHA256:@SECLEVEL=0", "AES128-SHA:@SECLEVEL=0", "ADH-AES128-SHA256:@SECLEVEL=0"]
)
async def test_weak_ciphers(ciphers: str, tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        with pytest.raises(aiohttp.ClientConnectorError):
            await served(coming, context(authority, ssl.TLSVersion.TLSv1_2, ciphers))


async def test_plain_text_is_no_way_in(tmp_path: Path) -> None:
    cert, key = Authority(tmp_path).issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        plain = coming.gateway.url.replace("https", "http")
        async with aiohttp.ClientSession() as session:
            with pytest.raises((aiohttp.ClientError, ConnectionError)):
                async with session.get(f"{plain}healthz"):
                    pass


async def test_applications_over_tls_with_a_token(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        async with Client(coming.gateway.url, token=fresh(), ca_file=authority.file) as client:
            assert (await client.get_profile()).profile is not None
        page = coming.gateway.url.rstrip("/")
        offered = ("openrois.v1", f"openrois.bearer.{fresh()}")
        async with coming.dial(offered=offered, origin=page, ssl=authority.context()) as connection:
            assert (await ask(connection, "rois.system.connect"))["result"] == {"return_code": "OK"}
        with pytest.raises(Exception, match="403"):
            await coming.dial(offered=offered, origin=page.replace("https", "http"), ssl=authority.context())


def serial_of(coming: Guarded, authority: Authority) -> str:
    port = int(coming.gateway.url.rstrip("/").rpartition(":")[2])
    with (
        socket.create_connection(("127.0.0.1", port), timeout=5) as raw,
        authority.context().wrap_socket(raw, server_hostname="127.0.0.1") as secure,
    ):
        found = secure.getpeercert()
        assert found is not None
        return str(found["serialNumber"])


async def test_a_new_certificate_without_dropping_a_connection(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        before = await asyncio.to_thread(serial_of, coming, authority)
        async with coming.dial(fresh(), ssl=authority.context()) as connection:
            authority.issue()
            coming.gateway.reload()
            assert await asyncio.to_thread(serial_of, coming, authority) != before
            assert (await ask(connection, "rois.system.connect"))["result"] == {"return_code": "OK"}
            newest = await asyncio.to_thread(serial_of, coming, authority)
            # Half of a pair, and nonsense: what was read before holds on.
            good_key = key.read_bytes()
            key.write_text("nonsense")
            coming.gateway.reload()
            assert await asyncio.to_thread(serial_of, coming, authority) == newest
            authority.issue()
            key.write_bytes(good_key)
            coming.gateway.reload()
            assert await asyncio.to_thread(serial_of, coming, authority) == newest


def test_what_is_no_certificate(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    with pytest.raises(ValueError, match="cannot be read: No such file"):
        Certificate(tmp_path / "nothing", key, time.time)
    with pytest.raises(ValueError, match="cannot be used"):
        Certificate(key, cert, time.time)
    authority.issue(password=b"canary-password")
    with pytest.raises(ValueError, match=r"cert\.pem.*encrypted with a password"):
        Certificate(cert, key, time.time)


def distrusted(cert: Path) -> None:
    """Make a certificate one that OpenSSL takes, and what reads its dates does not."""
    cert.write_text(cert.read_text().replace(" CERTIFICATE", " TRUSTED CERTIFICATE"))


async def test_what_only_one_of_two_readers_takes_is_not_used(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    async with guarded(tmp_path, tls_cert=cert, tls_key=key) as coming:
        before = await asyncio.to_thread(serial_of, coming, authority)
        authority.issue()
        distrusted(cert)
        coming.gateway.reload()
        assert await asyncio.to_thread(serial_of, coming, authority) == before
        assert any(f"{cert} and {key} cannot be used: " in said for said in caplog.messages)
    with pytest.raises(ValueError, match=r"cert\.pem and .* cannot be used: .*BEGIN CERTIFICATE"):
        Certificate(cert, key, time.time)


def test_a_key_that_signs_wrongly(tmp_path: Path) -> None:
    cert, key = Authority(tmp_path).issue()
    found = load_pem_private_key(key.read_bytes(), None)
    assert isinstance(found, EllipticCurvePrivateKey)
    secret = found.private_numbers().private_value.to_bytes(32, "big")
    whole = found.private_bytes(Encoding.DER, PrivateFormat.PKCS8, NoEncryption())
    wrong = whole.replace(secret, secret[:-1] + bytes([secret[-1] ^ 1]))
    lines = textwrap.wrap(base64.b64encode(wrong).decode(), 64)
    key.write_text("\n".join(["-----BEGIN PRIVATE KEY-----", *lines, "-----END PRIVATE KEY-----", ""]))
    with pytest.raises(ValueError, match=r"a handshake with them fails .*is the key damaged"):
        Certificate(cert, key, time.time)


def test_one_that_has_ended_is_used_and_said_to_have(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    cert, key = Authority(tmp_path).issue()
    end = Certificate(cert, key, time.time).ends
    assert end > time.time()
    assert not caplog.messages
    assert Certificate(cert, key, lambda: end).ends == end
    (said,) = caplog.messages
    assert said.startswith(f"the certificate {cert} expired on ")
