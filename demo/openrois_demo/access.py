"""Access to a demo: its address, its certificate, and the tokens that it issues to its own programs."""

import argparse
import asyncio
import time
from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from openrois.auth.claims import MAX_LIFETIME
from openrois.auth.issuing import issue_token
from openrois.auth.key_files import read_signing_key
from openrois.auth.loopback import is_loopback
from openrois.auth.principal import Role

__all__ = ["DemoAccess", "add_access_options", "demo_access"]

_TTL: Final = int(MAX_LIFETIME)
"""Lifetime of each token in seconds."""

_RENEWAL: Final = 1200.0
"""Seconds between two tokens of an adapter, well within the lifetime of one."""


@dataclass(frozen=True, slots=True)
class DemoAccess:
    """Address, certificate and key of a demo.

    Attributes:
        host: the address that its gateway listens on.
        name: host name of its gateway for programs, browsers, and in its certificate.
        tls_cert: the certificate; None for no TLS.
        tls_key: its private key.
        key: signs the tokens; None without authentication.
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

    def gateway_arguments(self) -> tuple[str, ...]:
        """Return the arguments of the gateway.

        Raises:
            ValueError: the key cannot be used.
        """
        given: list[str] = ["--host", self.host]
        if self.key is None:
            # Visitors of the page have names, and go before programs.
            given.append("--auth-local")
        if not is_loopback(self.name):
            given += ["--allow-host", self.name]
        if self.tls_cert is not None:
            given += ["--tls-cert", str(self.tls_cert), "--tls-key", str(self.tls_key)]
        if self.key is not None:
            # A private key stays here: the gateway gets the public key beside it.
            shared = read_signing_key(self.key)[0] == "HS256"
            given += ["--auth-key", str(self.key if shared else self.key.with_name(f"{self.key.name}.pub"))]
        return tuple(given)

    def viewer_token(self) -> str:
        """Return a new token for a program that only looks.

        Raises:
            ValueError: the key cannot be used.
        """
        return self._token("demo-viewer", Role.VIEWER, "*")

    def adapter_token(self, engine_id: str) -> str:
        """Return a new token for an adapter, which may offer the components of this engine and no others.

        Raises:
            ValueError: the key cannot be used.
        """
        return self._token(f"demo-{engine_id}", Role.ADAPTER, f"{engine_id}/*")

    @contextmanager
    def token_files(self, engine_ids: Iterable[str]) -> Iterator[Mapping[str, Path]]:
        """Yield a file with a token for each adapter, for as long as the block runs; none without authentication."""
        if self.key is None:
            yield {}
            return
        with TemporaryDirectory(prefix="openrois-demo-") as folder:
            paths = {engine_id: Path(folder, f"{engine_id}.token") for engine_id in engine_ids}
            self._write_tokens(paths)
            yield paths

    async def keep_tokens(
        self, paths: Mapping[str, Path], sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
    ) -> None:
        """Write new tokens into the files until cancelled, each long before the last one expires."""
        while paths:
            await sleep(_RENEWAL)
            self._write_tokens(paths)

    def _token(self, subject: str, role: Role, scope: str) -> str:
        assert self.key is not None
        return issue_token(self.key, subject, [role], [scope], now=int(time.time()), ttl=_TTL)

    def _write_tokens(self, paths: Mapping[str, Path]) -> None:
        for engine_id, path in paths.items():
            new = path.with_name(f"{path.name}.new")
            new.touch(0o600)
            new.write_text(f"{self.adapter_token(engine_id)}\n", encoding="ascii")
            # A reader always finds a whole token.
            new.replace(path)


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
    name = chosen.allow_host or chosen.host
    access = DemoAccess(chosen.host, name.lower(), chosen.tls_cert, chosen.tls_key, chosen.auth_key)
    access.gateway_arguments()
    return access
