"""Where NATS is, and what is shown to it: secrets are read from files at each use, and never said."""

import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from openrois.cluster.subjects import Subjects

__all__ = ["Login", "NatsSettings"]

_MAX_FILE: Final = 64 << 10


@dataclass(frozen=True, slots=True)
class Login:
    """What NATS is shown: a user and a password, or a token in place of them."""

    user: str = ""
    password: str = ""
    token: str = ""

    def __repr__(self) -> str:
        return "Login(...)"


@dataclass(frozen=True, slots=True)
class NatsSettings:
    """How a gateway gets to NATS.

    Attributes:
        servers: `nats://host:port`, or `tls://host:port`, to which nothing is said before the connection is encrypted;
            tried in this order.
        credentials_file: a token in one line, or a user and a password in two; None for nothing.
        ca_file: authorities (PEM) that may have signed the servers' certificates; None for those of the system.
        certificate_file: a certificate (PEM) to be shown to the servers.
        key_file: its key (PEM), where that is not in the same file.
        prefix: leads all subjects; another one for each cluster of gateways at the same NATS.
    """

    servers: tuple[str, ...]
    credentials_file: Path | None = None
    ca_file: Path | None = None
    certificate_file: Path | None = None
    key_file: Path | None = None
    prefix: str = "openrois"

    def __post_init__(self) -> None:
        if not self.servers:
            raise ValueError("no server of NATS is named: give one, such as nats://127.0.0.1:4222")
        for server in self.servers:
            _check(server)
        if self.key_file is not None and self.certificate_file is None:
            raise ValueError("a key is of no use without its certificate: name the file of the certificate too")
        Subjects(self.prefix)

    @property
    def names_tls(self) -> bool:
        """Whether files for TLS are named."""
        return self.ca_file is not None or self.certificate_file is not None

    def login(self) -> Login | None:
        """Read the credentials.

        Raises:
            ValueError: they cannot be read; the message does not say what is in the file.
        """
        path = self.credentials_file
        if path is None:
            return None
        try:
            with path.open("rb") as file:
                lines = file.read(_MAX_FILE).decode("ascii", "replace").split()
        except OSError as error:
            raise ValueError(f"the credentials for NATS cannot be read from {path}: {error.strerror}") from None
        if len(lines) not in (1, 2) or not all(line.isascii() and line.isprintable() for line in lines):
            raise ValueError(
                f"{path} holds no credentials for NATS: a token in one line, or a user and a password in two"
            )
        return Login(token=lines[0]) if len(lines) == 1 else Login(*lines)

    def context(self) -> ssl.SSLContext:
        """Return the TLS context.

        Raises:
            ValueError: a file cannot be used.
        """
        named: Path | None = self.ca_file
        try:
            context = ssl.create_default_context(cafile=None if named is None else str(named))
            if (named := self.certificate_file) is not None:
                context.load_cert_chain(named, self.key_file, password=lambda: "")
        except OSError as error:
            raise ValueError(f"{named} cannot be used for TLS with NATS: {error.strerror or error}") from None
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        return context


def _check(server: str) -> None:
    """Refuse what is no address of a server.

    Raises:
        ValueError: it is none, or carries a password.
    """
    problem = f"{server!r} is no address of a NATS server, such as nats://127.0.0.1:4222 or tls://nats.example:4222"
    if "@" in server:
        raise ValueError("credentials for NATS do not belong in an address, where logs would keep them: name a file")
    try:
        parts = urlsplit(server)
        port = parts.port
    except ValueError:
        raise ValueError(problem) from None
    if parts.scheme not in ("nats", "tls") or not parts.hostname or parts.path.strip("/") or parts.query or port == 0:
        raise ValueError(problem)
