"""A new token on a connection that goes on: `openrois.auth.refresh`, and the notice that the present one soon ends."""

from collections.abc import Callable
from typing import Any, Final

from openrois.auth.principal import Principal
from openrois.auth.refusal import Refusal, TokenRefused
from openrois.auth.tokens import TokenVerifier
from openrois.errors import BadParameter, Unsupported
from openrois.gateway.token_expiry import TokenExpiry
from openrois.interfaces.operation import operation
from openrois.jsonrpc.session import Handler
from openrois.observability.audit import Audit
from openrois.types.access import AuthExpiringNotification, AuthRefreshParams, AuthRefreshResult

__all__ = ["REFRESH", "Renewal", "expiring"]

REFRESH: Final = "openrois.auth.refresh"


class Renewal:
    """Takes new tokens.

    Args:
        verifier: tells whom a token is for; None where no token is needed.
        clock: epoch seconds.
        audit: hears of every new token.
    """

    def __init__(self, verifier: TokenVerifier | None, clock: Callable[[], float], audit: Audit) -> None:
        self._verifier = verifier
        self._clock = clock
        self._audit = audit

    def method(
        self, tenure: TokenExpiry, fits: Callable[[Principal], bool], refused: Callable[[str], None]
    ) -> dict[str, Handler]:
        """Return the method for one connection.

        Args:
            tenure: how long the connection may last.
            fits: whether the connection may be the principal's.
            refused: hears what was wrong with a token that is not taken, for the audit trail.
        """

        async def refresh(params: AuthRefreshParams) -> AuthRefreshResult:
            if self._verifier is None:
                raise Unsupported("this gateway asks for no tokens")
            try:
                principal = await self._verifier.verify(params.token)
                if principal.subject != tenure.principal.subject:
                    raise TokenRefused(Refusal.SUBJECT)
                if not fits(principal) or tenure.is_over:
                    raise TokenRefused(Refusal.ROLE)
            except TokenRefused as error:
                refused(error.reason.value)
                # The same sentence for all of them: nobody learns what was wrong with a token.
                raise BadParameter("a valid token of the same subject is needed") from None
            self._audit.acted(
                principal, REFRESH, "", f"in place of {tenure.principal.token_id or 'a token without id'}"
            )
            tenure.replace(principal)
            ends = principal.expires
            return AuthRefreshResult(seconds=0 if ends is None else max(0, int(ends - self._clock())))

        return {REFRESH: operation(AuthRefreshParams, AuthRefreshResult, refresh)}


def expiring(notify: Callable[..., None], understands: Callable[[], bool]) -> Callable[[float], bool]:
    """Return what tells the other side that its token ends soon, where it would understand that."""

    def tell(seconds: float) -> bool:
        if not understands():
            return False
        told: dict[str, Any] = AuthExpiringNotification(seconds=max(0, int(seconds))).model_dump(mode="json")
        notify(AuthExpiringNotification.method, told)
        return True

    return tell
