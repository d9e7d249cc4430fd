"""Settings of admission: keys, issuers, origins, hosts, and TLS."""

from pathlib import Path
from typing import ClassVar, Final, Self

from pydantic import model_validator

from openrois.auth.claims import MAX_LIFETIME
from openrois.auth.jwks import flaw_of_address
from openrois.auth.ranks import DEFAULT_RANKS, Ranks
from openrois.gateway.origins import parse_origin
from openrois.gateway.settings_group import SettingsGroup, require_between, setting

__all__ = ["Authentication", "Encryption"]

_DAY: Final = 86400.0


class Authentication(SettingsGroup):
    """Validity of tokens, and the pages that may connect."""

    table: ClassVar[str] = "auth"

    auth_keys: tuple[Path, ...] = setting(
        (), "holds keys for tokens: public ones in PEM, or a secret for HS256", metavar="FILE"
    )
    auth_jwks: str = setting("", "the https address of the issuer's JSON Web Key Set", metavar="URL")
    auth_jwks_file: Path | None = setting(None, "holds the issuer's JSON Web Key Set", metavar="FILE")
    auth_local: bool = setting(
        False, "gives each page of this machine a token with the rank of a person; who shows none ranks lowest"
    )
    auth_issuer: str = setting("", "what the claim iss of every token has to be", metavar="TEXT")
    auth_audience: str = setting("", "what the claim aud of every token has to name", metavar="TEXT")
    auth_max_lifetime: float = setting(MAX_LIFETIME, "seconds that a token may last", metavar="SECONDS")
    ranks: str = setting(
        ",".join(DEFAULT_RANKS), "ranks of tokens, the highest first: that of people", metavar="NAME,NAME..."
    )
    auth_revocations: Path | None = setting(
        None, "lists revoked subjects and tokens: lines `sub NAME` and `jti ID`", metavar="FILE"
    )
    allow_origins: tuple[str, ...] = setting(
        (), "a web site whose pages may connect, beside the gateway's own", metavar="ORIGIN"
    )
    allow_hosts: tuple[str, ...] = setting((), "a name by which the gateway is called", metavar="NAME")

    @property
    def is_authenticated(self) -> bool:
        """Whether a token is needed."""
        return not self.auth_local and bool(self.auth_keys or self.auth_jwks or self.auth_jwks_file)

    @model_validator(mode="after")
    def _check_authentication(self) -> Self:
        if sum(map(bool, (self.auth_keys, self.auth_jwks, self.auth_jwks_file))) > 1:
            raise ValueError("give only one of --auth-key, --auth-jwks and --auth-jwks-file")
        if self.auth_local and (self.auth_jwks or self.auth_jwks_file):
            raise ValueError("--auth-local cannot be used with --auth-jwks: of keys beside its own it takes --auth-key")
        if self.auth_jwks and (flaw := flaw_of_address(self.auth_jwks)):
            raise ValueError(f"{self.auth_jwks[:200]!r} cannot be the address of the issuer's keys: {flaw}")
        if not self.is_authenticated and (self.auth_issuer or self.auth_audience or self.auth_revocations):
            raise ValueError(
                "--auth-issuer, --auth-audience and --auth-revocations require --auth-key or --auth-jwks, and "
                "cannot be used with --auth-local"
            )
        try:
            Ranks.parse(self.ranks)
        except ValueError as error:
            raise ValueError(f"--ranks {self.ranks[:200]!r} cannot be used: {error}") from None
        require_between("--auth-max-lifetime", self.auth_max_lifetime, 60, _DAY, "seconds")
        return self

    @model_validator(mode="after")
    def _check_names(self) -> Self:
        for origin in self.allow_origins:
            if parse_origin(origin) is None:
                raise ValueError(f"{origin[:200]!r} is no origin: write it as https://app.example.org")
        for host in self.allow_hosts:
            if parse_origin(f"http://{host.lower()}") is None or ":" in host.rpartition("]")[2]:
                raise ValueError(f"{host[:200]!r} is no name of a host: write it as gateway.example.org")
        return self


class Encryption(SettingsGroup):
    """TLS of the one port."""

    table: ClassVar[str] = "tls"

    tls_cert: Path | None = setting(None, "the certificate with its chain, in PEM", metavar="FILE")
    tls_key: Path | None = setting(None, "its private key, in PEM", metavar="FILE")
    tls_elsewhere: bool = setting(False, "something in front of the gateway does TLS, and nothing else reaches it")

    @model_validator(mode="after")
    def _check_encryption(self) -> Self:
        if (self.tls_cert is None) != (self.tls_key is None):
            raise ValueError("--tls-cert and --tls-key must be given together")
        if self.tls_elsewhere and self.tls_cert is not None:
            raise ValueError("give either --tls-elsewhere or --tls-cert, not both")
        return self
