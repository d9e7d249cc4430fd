"""Admission, tokens and their end, put together from the settings."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.auth.claims import ClaimRules
from openrois.auth.jwks import KeySetCache, fetch_from_file, fetch_from_url
from openrois.auth.key_files import read_keys
from openrois.auth.keys import KeySource, StoredKeys, VerificationKey
from openrois.auth.principal import Principal
from openrois.auth.ranks import Ranks
from openrois.auth.revocations import NOTHING_REVOKED, Revocations, parse_revocations
from openrois.auth.tokens import TokenVerifier
from openrois.gateway.admission import Admission, origin_rules
from openrois.gateway.encryption import Certificate
from openrois.gateway.page_tokens import PageTokens
from openrois.gateway.reloading import Reloader
from openrois.gateway.renewal import Renewal
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.sign_in import SignIns
from openrois.gateway.token_expiry import TokenExpiries
from openrois.observability.audit import Audit

__all__ = ["AuthSetup"]

_LONGEST_LIST: Final = 16 << 20
"""Characters of a list of revocations."""


@dataclass(frozen=True, slots=True)
class AuthSetup:
    """Admission to a gateway, and what it watches.

    Attributes:
        admission: admits or refuses requests.
        expiries: closes connections when their tokens end.
        renewal: how that is made longer.
        sign_ins: records sign-ins and sign-outs.
        certificate: what TLS is done with; None for none.
        reloader: reads again what has changed: keys, revocations, the certificate.
        page_tokens: gives them to the gateway's own page; None where visitors bring theirs, or need none.
    """

    admission: Admission
    expiries: TokenExpiries
    renewal: Renewal
    sign_ins: SignIns
    certificate: Certificate | None
    reloader: Reloader
    page_tokens: PageTokens | None

    @classmethod
    def open(
        cls,
        settings: GatewaySettings,
        audit: Audit,
        tasks: TaskScope,
        turned_away: Callable[[str], None],
        clock: Callable[[], float] = time.time,
    ) -> "AuthSetup":
        """Read keys and lists, and begin to watch them and every connection.

        Args:
            settings: what the gateway's owner sets.
            audit: records every refusal.
            tasks: owns what goes on.
            turned_away: counts refused connections by reason.
            clock: epoch seconds.

        Raises:
            ValueError: a file cannot be read, or is not what it has to be.
        """
        reloader = Reloader()
        revoked = _Revoked(settings.auth_revocations, reloader)
        verifier = page_tokens = None
        ranks = Ranks.parse(settings.ranks)
        if settings.auth_local:
            page_tokens = PageTokens(ranks, settings.auth_max_lifetime, clock)
        if settings.is_authenticated or page_tokens is not None:
            rules = ClaimRules(settings.auth_issuer, settings.auth_audience, settings.auth_max_lifetime, ranks=ranks)
            keys = _keys(settings, reloader, tasks, () if page_tokens is None else page_tokens.keys)
            verifier = TokenVerifier(keys, rules, clock, revoked.covers)
        certificate = None
        if settings.tls_cert is not None and settings.tls_key is not None:
            certificate = Certificate(settings.tls_cert, settings.tls_key, clock)
            reloader.add((settings.tls_cert, settings.tls_key), certificate.load, "the certificate")
        expiries = TokenExpiries(clock, revoked.covers, audit, tasks)
        revoked.on_read = expiries.check_tokens
        tasks.start(reloader.run())
        tasks.start(expiries.watch())
        admission = Admission(origin_rules(settings), verifier, audit, turned_away, is_optional=page_tokens is not None)
        renewal = Renewal(None if verifier is None else verifier.verify, clock, audit)
        return cls(admission, expiries, renewal, SignIns(audit), certificate, reloader, page_tokens)


def _keys(settings: GatewaySettings, reloader: Reloader, tasks: TaskScope, own: Sequence[VerificationKey]) -> KeySource:
    if settings.auth_jwks:
        return KeySetCache(fetch_from_url(settings.auth_jwks), time.monotonic, tasks)
    if settings.auth_jwks_file is not None:
        return KeySetCache(fetch_from_file(settings.auth_jwks_file), time.monotonic, tasks)
    stored = StoredKeys((*own, *read_keys(settings.auth_keys)))

    def read_again() -> None:
        stored.keys = (*own, *read_keys(settings.auth_keys))

    reloader.add(settings.auth_keys, read_again, "the keys for tokens")
    return stored


class _Revoked:
    """The list of revocations, as the file is now.

    Attributes:
        on_read: called when it was read again.
    """

    def __init__(self, path: Path | None, reloader: Reloader) -> None:
        self.on_read: Callable[[], None] = lambda: None
        self._list: Revocations = NOTHING_REVOKED
        if path is not None:
            self._read(path)
            reloader.add((path,), lambda: self._read_again(path), "the list of revocations")

    def _read_again(self, path: Path) -> None:
        self._read(path)
        self.on_read()

    def _read(self, path: Path) -> None:
        try:
            with path.open(encoding="utf-8") as file:
                text = file.read(_LONGEST_LIST + 1)
            if len(text) > _LONGEST_LIST:
                raise ValueError("it is too long")
            self._list = parse_revocations(text)
        except OSError as error:
            raise ValueError(f"{path} cannot be read: {error.strerror}") from None
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    def covers(self, principal: Principal) -> bool:
        return self._list.covers(principal)
