"""A new token on an open connection: `openrois.auth.refresh`, and the notice that the present one soon ends."""

from collections.abc import Awaitable, Callable
from typing import Any, Final

from openrois.auth.principal import Principal
from openrois.auth.refusal import Refusal, TokenRefused
from openrois.errors import BadParameter, Unsupported
from openrois.gateway.token_expiry import TokenExpiry
from openrois.interfaces.operation import operation
from openrois.jsonrpc.session import Handler
from openrois.observability.audit import Audit
from openrois.types.access import AuthExpiringNotification, AuthRefreshParams, AuthRefreshResult

__all__ = ["REFRESH", "Renewal", "expiring"]

REFRESH: Final = "openrois.auth.refresh"


class Renewal:
    """Accepts new tokens.

    Args:
        verify: returns the principal of a token or raises `TokenRefused`; None where no token is needed.
        clock: epoch seconds.
        audit: records every new token.
    """

    def __init__(
        self, verify: Callable[[str], Awaitable[Principal]] | None, clock: Callable[[], float], audit: Audit
    ) -> None:
        self._verify = verify
        self._clock = clock
        self._audit = audit

    def method(
        self, expiry: TokenExpiry, fits: Callable[[Principal], bool], refused: Callable[[str], None]
    ) -> dict[str, Handler]:
        """Return the method for one connection.

        Args:
            expiry: how long the connection may last.
            fits: whether the connection may be the principal's.
            refused: gets the reason of a refusal, for the audit trail.
        """

        async def refresh(params: AuthRefreshParams) -> AuthRefreshResult:
            if self._verify is None:
                raise Unsupported("this gateway asks for no tokens")
            try:
                principal = await self._verify(params.token)
                if principal.subject != expiry.principal.subject:
                    raise TokenRefused(Refusal.SUBJECT)
                if not fits(principal) or expiry.is_over:
                    raise TokenRefused(Refusal.ROLE)
            except TokenRefused as error:
                refused(error.reason.value)
                # The same sentence for all of them: a client learns nothing about a token by trying.
                raise BadParameter("a valid token of the same subject is needed") from None
            self._audit.acted(
                principal, REFRESH, "", f"in place of {expiry.principal.token_id or 'a token without id'}"
            )
            expiry.replace(principal)
            ends = principal.expires
            return AuthRefreshResult(seconds=0 if ends is None else max(0, int(ends - self._clock())))

        return {REFRESH: operation(AuthRefreshParams, AuthRefreshResult, refresh)}


def expiring(notify: Callable[..., None], understands: Callable[[], bool]) -> Callable[[float], bool]:
    """Return a function that notifies the other side that its token ends soon, where it knows that notification."""

    def tell(seconds: float) -> bool:
        if not understands():
            return False
        told: dict[str, Any] = AuthExpiringNotification(seconds=max(0, int(seconds))).model_dump(mode="json")
        notify(AuthExpiringNotification.method, told)
        return True

    return tell
