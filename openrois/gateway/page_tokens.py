"""Tokens that a gateway for this machine alone gives to its own page: visitors have names, and the rank of people."""

import secrets
import time
from collections.abc import Callable
from typing import Final

from openrois.auth.issuing import sign_token
from openrois.auth.keys import VerificationKey
from openrois.auth.principal import LOCAL, Principal, Role
from openrois.auth.ranks import Ranks

__all__ = ["PageTokens"]

_NOT_OF_PAGES: Final = frozenset({Role.ADMINISTRATOR, Role.ADAPTER})


class PageTokens:
    """Signs with a secret that no other process has, and that ends with the gateway.

    Args:
        ranks: the highest is that of each visitor.
        lifetime: seconds for which a token is good.
        clock: epoch seconds.

    Attributes:
        keys: what the tokens are verified with.
    """

    def __init__(self, ranks: Ranks, lifetime: float, clock: Callable[[], float] = time.time) -> None:
        self._secret = secrets.token_urlsafe(48).encode()
        self._ranks = ranks
        self._lifetime = int(lifetime)
        self._clock = clock
        self._visitors = 0
        self.keys = (VerificationKey("HS256", self._secret),)

    def issue(self, former: Principal) -> str:
        """Return a token for a page: one of the same subject for one that shows a token, else for a new visitor."""
        if former is LOCAL:
            self._visitors += 1
        subject = f"visitor {self._visitors}" if former is LOCAL else former.subject
        roles = sorted((LOCAL.roles - _NOT_OF_PAGES) | {Role.OPERATOR})
        rank = self._ranks.names[0]
        now = int(self._clock())
        return sign_token("HS256", self._secret, subject, roles, ["*"], now=now, ttl=self._lifetime, rank=rank)
