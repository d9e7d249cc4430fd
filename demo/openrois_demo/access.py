"""Access to a demo: its address, its certificate, and the key of its tokens."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from openrois.auth.key_files import read_signing_key
from openrois.auth.loopback import is_loopback

__all__ = ["DemoAccess", "add_access_options", "demo_access"]


@dataclass(frozen=True, slots=True)
class DemoAccess:
    """Address, certificate and key of a demo.

    Attributes:
        host: the address that its gateway listens on.
        name: host name of its gateway for programs, browsers, and in its certificate.
        tls_cert: the certificate; None for no TLS.
        tls_key: its private key.
        key: signs the tokens; None where visitors and programs of this machine need none.
    """

    host: str = "127.0.0.1"
    name: str = "127.0.0.1"
    tls_cert: Path | None = None
    tls_key: Path | None = None
    key: Path | None = None

    def url(self, scheme: str, port: int) -> str:
        """Return an address of the gateway; `scheme` is `http` or `ws`, and gets its `s` where there is TLS."""
        name = f"[{self.name}]" if ":" in self.name else self.name
        return f"{scheme}{'' if self.tls_cert is None else 's'}://{name}:{port}/"

    def gateway_arguments(self, signing: Path) -> tuple[str, ...]:
        """Return the arguments of the gateway.

        Args:
            signing: the key of the tokens that the demo issues.

        Raises:
            ValueError: the key cannot be used.
        """
        # A private key stays here: the gateway gets the public key beside it.
        is_shared = read_signing_key(signing)[0] == "HS256"
        verifying = signing if is_shared else signing.with_name(f"{signing.name}.pub")
        given = ["--host", self.host, "--auth-key", str(verifying)]
        if self.key is None:
            # Visitors of the page have names, and go before programs.
            given.append("--auth-local")
        if not is_loopback(self.name):
            given += ["--allow-host", self.name]
        if self.tls_cert is not None:
            given += ["--tls-cert", str(self.tls_cert), "--tls-key", str(self.tls_key)]
        return tuple(given)


def add_access_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for access from other machines."""
    group = parser.add_argument_group("reached from other machines")
    group.add_argument("--host", default="127.0.0.1", metavar="ADDRESS", help="address to listen on (%(default)s)")
    group.add_argument("--allow-host", metavar="NAME", help="what this machine is called, and its certificate says")
    group.add_argument("--tls-cert", type=Path, metavar="FILE", help="the certificate with its chain, in PEM")
    group.add_argument("--tls-key", type=Path, metavar="FILE", help="its private key, in PEM")
    group.add_argument(
        "--auth-key",
        type=Path,
        metavar="FILE",
        help="what tokens are signed with, as `openrois token new-key` makes it: each visitor of the page needs one",
    )


def demo_access(chosen: argparse.Namespace) -> DemoAccess:
    """Return the access that the options describe.

    Raises:
        ValueError: options contradict each other, or the key cannot be used.
    """
    if (chosen.tls_cert is None) != (chosen.tls_key is None):
        raise ValueError("--tls-cert and --tls-key must be given together")
    if not is_loopback(chosen.host) and None in (chosen.tls_cert, chosen.auth_key):
        raise ValueError(
            f"--host {chosen.host} can be reached from other machines; it requires --tls-cert, --tls-key and --auth-key"
        )
    if chosen.host in ("0.0.0.0", "::") and chosen.allow_host is None:  # noqa: S104
        raise ValueError(
            f"--host {chosen.host} is every address; it requires --allow-host with the name of this machine"
        )
    if chosen.auth_key is not None and chosen.token_file is not None:
        raise ValueError("--token-file cannot be used with --auth-key: the demo issues the tokens itself")
    if chosen.auth_key is not None:
        read_signing_key(chosen.auth_key)
    name = chosen.allow_host or chosen.host
    return DemoAccess(chosen.host, name.lower(), chosen.tls_cert, chosen.tls_key, chosen.auth_key)
