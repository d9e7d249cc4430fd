"""Certificate and tokens for one bench, as a gateway on the internet has them."""

import datetime as dt
import ipaddress
import secrets
import ssl
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import jwt
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

__all__ = ["OPEN", "TLS", "Secured", "Security"]

LIFETIME: Final = 3600
"""Seconds that tokens last; no bench is as long."""


@dataclass(frozen=True, slots=True)
class Secured:
    """Credentials of the processes of a bench.

    Attributes:
        gateway: options of the gateway.
        certificate: files with what a server shows and its key; empty without TLS.
        adapter: what stands in the adapter's environment.
        context: what applications check the gateway's certificate with; None without TLS.
        token: what they show; empty if the gateway asks for none.
    """

    gateway: tuple[str, ...] = ()
    certificate: tuple[str, ...] = ()
    adapter: tuple[tuple[str, str], ...] = ()
    context: ssl.SSLContext | None = None
    token: str = ""


@dataclass(frozen=True, slots=True)
class Security:
    """Protection of a gateway while it is measured.

    Attributes:
        tls: whether all connections are encrypted.
        auth: whether clients need a token with roles and scope, and are recorded in an audit trail.
    """

    tls: bool = False
    auth: bool = False

    def __str__(self) -> str:
        tls = "TLS" if self.tls else "no TLS"
        return f"{tls}, {'tokens, authorization and audit' if self.auth else 'no authentication'}"

    @contextmanager
    def prepared(self, scope: str) -> Iterator[Secured]:
        """Make what is needed, for as long as the block runs.

        Args:
            scope: the components that operators and adapters are let to.
        """
        with TemporaryDirectory(prefix="openrois-bench-") as name:
            folder = Path(name)
            gateway: list[str] = []
            files: tuple[str, ...] = ()
            adapter: dict[str, str] = {}
            context, token = None, ""
            if self.tls:
                certificate, key = files = _certificate(folder)
                gateway += ("--tls-cert", certificate, "--tls-key", key)
                adapter["OPENROIS_CA_FILE"] = certificate
                context = ssl.create_default_context(cafile=certificate)
            if self.auth:
                secret = secrets.token_urlsafe(48)
                gateway += ("--auth-key", str(_secret(folder / "key", secret)))
                gateway += ("--audit-file", str(folder / "audit"))
                adapter["OPENROIS_TOKEN_FILE"] = str(_secret(folder / "token", _token(secret, "adapter", scope)))
                token = _token(secret, "operator", scope)
            yield Secured(tuple(gateway), files, tuple(adapter.items()), context, token)


OPEN: Final = Security()
TLS: Final = Security(tls=True)


def _secret(file: Path, text: str) -> Path:
    file.touch(0o600)
    file.write_text(text)
    return file


def _token(secret: str, role: str, scope: str) -> str:
    now = int(time.time())
    claims = {"sub": f"bench {role}", "roles": [role], "scope": scope, "iat": now, "exp": now + LIFETIME}
    return jwt.encode(claims, secret, algorithm="HS256")


def _certificate(folder: Path) -> tuple[str, str]:
    """Write a certificate of this machine that it has signed itself, and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "openrois bench")])
    now = dt.datetime.now(dt.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - dt.timedelta(hours=1))
        .not_valid_after(now + dt.timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, SHA256())
    )
    files = folder / "cert.pem", folder / "cert.key"
    files[0].write_bytes(certificate.public_bytes(Encoding.PEM))
    text = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()).decode()
    return str(files[0]), str(_secret(files[1], text))
