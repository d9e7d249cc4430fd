"""Certificates of tests: an authority of their own, and what it signs."""

import datetime as dt
import ipaddress
import ssl
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import BestAvailableEncryption, Encoding, NoEncryption, PrivateFormat

_BEGIN = dt.datetime(2020, 1, 1, tzinfo=dt.UTC)
_END = dt.datetime(2090, 1, 1, tzinfo=dt.UTC)


def _name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, text)])


@dataclass
class Authority:
    """Signs certificates for this machine."""

    folder: Path
    key: Any = field(default_factory=lambda: ec.generate_private_key(ec.SECP256R1()))
    serial: int = 1

    def __post_init__(self) -> None:
        own = self._begun("authority", self.key.public_key())
        own = own.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        own = own.add_extension(
            x509.KeyUsage(False, False, False, False, False, True, True, False, False), critical=True
        )
        self.file = self.folder / "ca.pem"
        self.file.write_bytes(own.sign(self.key, SHA256()).public_bytes(Encoding.PEM))

    def _begun(self, subject: str, public_key: Any) -> x509.CertificateBuilder:
        self.serial += 1
        begun = x509.CertificateBuilder().subject_name(_name(subject)).issuer_name(_name("authority"))
        begun = begun.public_key(public_key).serial_number(self.serial)
        begun = begun.add_extension(x509.SubjectKeyIdentifier.from_public_key(public_key), critical=False)
        return begun.not_valid_before(_BEGIN).not_valid_after(_END)

    def issue(self, *, password: bytes | None = None) -> tuple[Path, Path]:
        """Write a new certificate and its key over the former ones; return their files."""
        key = ec.generate_private_key(ec.SECP256R1())
        names = [x509.DNSName("localhost"), x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]
        made = self._begun("localhost", key.public_key())
        made = made.add_extension(x509.SubjectAlternativeName(names), critical=False)
        made = made.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        made = made.add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(self.key.public_key()), False)
        cert_file, key_file = self.folder / "cert.pem", self.folder / "cert.key"
        cert_file.write_bytes(made.sign(self.key, SHA256()).public_bytes(Encoding.PEM))
        lock = NoEncryption() if password is None else BestAvailableEncryption(password)
        key_file.write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, lock))
        key_file.chmod(0o600)
        return cert_file, key_file

    def context(self) -> ssl.SSLContext:
        """Return a client's context that trusts this authority alone."""
        return ssl.create_default_context(cafile=str(self.file))
