"""TLS of the gateway's port: at least 1.2, with a certificate that may change while connections go on."""

import datetime as dt
import logging
import ssl
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from cryptography import x509

__all__ = ["Certificate"]

_log = logging.getLogger(__name__)


class Certificate:
    """A certificate and its key, and the context of every connection that is made with them.

    Args:
        cert: the file of the certificate, with its chain.
        key: the file of its key.
        clock: epoch seconds.

    Attributes:
        context: what the server accepts connections with; those that are open keep what they have.
        ends: epoch seconds; clients that connect later do not trust it.

    Raises:
        ValueError: they cannot be used.
    """

    def __init__(self, cert: Path, key: Path, clock: Callable[[], float]) -> None:
        self._cert = cert
        self._key = key
        self._clock = clock
        self.context = _context()
        self.load()

    def load(self) -> None:
        """Read both files, for all later connections.

        Raises:
            ValueError: they cannot be used; the previous certificate stays in use.
        """
        try:
            # Read into a context of its own: half of a pair must not get into the one in use.
            tried = _context()
            tried.load_cert_chain(self._cert, self._key, password=_no_password)
            end = _end(self._cert)
            _shake_hands(tried)
            self.context.load_cert_chain(self._cert, self._key, password=_no_password)
        except ssl.SSLError as error:
            reason = error.reason or "they are no certificate and key"
            raise ValueError(f"{self._cert} and {self._key} cannot be used: {reason}") from None
        except OSError as error:
            raise ValueError(f"{self._cert} and {self._key} cannot be read: {error.strerror}") from None
        except ValueError as error:
            raise ValueError(f"{self._cert} and {self._key} cannot be used: {error}") from None
        self.ends = end.timestamp()
        if self.ends <= self._clock():
            _log.warning("the certificate %s expired on %s, and clients refuse it: replace it", self._cert, end.date())


def _context() -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.options |= ssl.OP_NO_RENEGOTIATION | ssl.OP_NO_COMPRESSION
    context.set_alpn_protocols(["http/1.1"])
    return context


def _shake_hands(context: ssl.SSLContext) -> None:
    """Try a handshake, in memory: a damaged key may still name the certificate's public key and sign wrongly.

    Raises:
        ValueError: no client could connect.
    """
    client_context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    client_context.check_hostname, client_context.verify_mode = False, ssl.CERT_NONE
    to_server, to_client = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = client_context.wrap_bio(to_client, to_server)
    server = context.wrap_bio(to_server, to_client, server_side=True)
    try:
        # TLS 1.2 takes two turns, 1.3 one.
        for side in (client, server) * 3:
            with suppress(ssl.SSLWantReadError):
                side.do_handshake()
    except ssl.SSLError as error:
        reason = error.reason or "no reason is given"
        raise ValueError(f"a handshake with them fails ({reason}): is the key damaged?") from None


def _end(cert: Path) -> dt.datetime:
    """Return when a certificate ends; of some that OpenSSL accepts this cannot be known."""
    try:
        return x509.load_pem_x509_certificate(cert.read_bytes()).not_valid_after_utc
    except (ValueError, x509.InvalidVersion):
        raise ValueError("the first file has no X.509 certificate in PEM (BEGIN CERTIFICATE)") from None


def _no_password() -> str:
    """Answer for a locked key: there is no terminal to ask at."""
    raise ValueError("the key is encrypted with a password: store it without one")
