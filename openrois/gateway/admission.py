"""Admission: every request's address, host and origin, and the token of every connection."""

import logging
import re
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final

from aiohttp import web

from openrois.auth.principal import LOCAL, Principal
from openrois.auth.refusal import Refusal, TokenRefused
from openrois.auth.tokens import TokenVerifier
from openrois.gateway.audit_rate import AuditRate
from openrois.gateway.origins import OriginRules, parse_origin
from openrois.gateway.settings import GatewaySettings
from openrois.observability.audit import Audit
from openrois.observability.logs import Tally

__all__ = ["SUBPROTOCOL", "Admission", "guard", "origin_rules"]

_log = logging.getLogger(__name__)

SUBPROTOCOL: Final = "openrois.v1"
"""The subprotocol that a browser offers beside the token, and that is answered."""

REFUSED_AT_ONCE: Final = 1000
"""Refused connections without a valid token that the audit trail records one by one; as many of those with one."""

REFUSED_PER_SECOND: Final = 10
"""Of each in the long run; of more the next record says how many there were."""

_BEARER: Final = "openrois.bearer."
_BLANKS: Final = " \t"
"""What may stand around a value in a header (RFC 9110 section 5.6.3), which is less than Python takes for a blank."""

_TOKEN_NAMES: Final = frozenset({"token", "access_token", "id_token", "auth", "authorization", "bearer", "jwt"})
_TOKEN: Final = re.compile(r"eyJ[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+\.")
_WILDCARDS: Final = frozenset({"0.0.0.0", "::", ""})  # noqa: S104
_PROBED: Final = frozenset({"/healthz", "/readyz"})
"""Probes of a process manager come from addresses of its own; they learn nothing of the inside."""

_CHALLENGE: Final = {"WWW-Authenticate": 'Bearer realm="openrois"'}


def origin_rules(settings: GatewaySettings) -> OriginRules:
    """Return which pages may connect to a gateway with these settings, and by which names."""
    sites = (parse_origin(origin) for origin in settings.allow_origins)
    names = {name.lower().strip("[]") for name in (*settings.allow_hosts, settings.host)} - _WILDCARDS
    secure = settings.tls_cert is not None or settings.tls_elsewhere
    return OriginRules(
        origins=frozenset(site for site in sites if site is not None),
        hosts=frozenset(names),
        local=not settings.is_authenticated,
        scheme="https" if secure else "http",
    )


@dataclass
class Admission:
    """Admits or refuses requests. The client learns no reason; the audit trail does.

    Attributes:
        rules: which pages may connect, and what the gateway may be called.
        verifier: verifies tokens; None where no token is needed.
        audit: records every refusal.
        turned_away: counts them by reason.
        clock: monotonic seconds.
        is_optional: whether a request without a token is admitted as one of this machine.
    """

    rules: OriginRules
    verifier: TokenVerifier | None
    audit: Audit
    turned_away: Callable[[str], None] = lambda _reason: None
    clock: Callable[[], float] = time.monotonic
    is_optional: bool = False

    def __post_init__(self) -> None:
        self._tally = Tally(_log, "refused connections")
        # Refusals without a token, however many, do not hide those with one, and do not fill a disk.
        self._audit_rates = {
            known: AuditRate(REFUSED_AT_ONCE, REFUSED_PER_SECOND, self.clock) for known in (False, True)
        }

    async def application(self, request: web.Request) -> Principal:
        """Return the principal of an application that connects.

        Raises:
            web.HTTPUnauthorized: no token came, or it is not good.
            web.HTTPForbidden: it is good for something else.
        """
        principal = await self._principal(request)
        if not principal.is_application:
            raise self._not_for_this(request, principal)
        return principal

    async def adapter(self, request: web.Request) -> Principal:
        """Return the principal of an adapter that connects.

        Raises:
            web.HTTPUnauthorized: no token came, or it is not good.
            web.HTTPForbidden: it is good for something else.
        """
        principal = await self._principal(request)
        if not principal.is_adapter:
            raise self._not_for_this(request, principal)
        return principal

    def _not_for_this(self, request: web.Request, principal: Principal) -> web.HTTPException:
        self._note(request, Refusal.ROLE, principal.subject)
        return web.HTTPForbidden(
            text="the token is not for this: adapters need the role adapter, applications another\n"
        )

    async def _principal(self, request: web.Request) -> Principal:
        offered = _offered(request)
        tokens = [name.removeprefix(_BEARER) for name in offered if name.startswith(_BEARER)]
        if SUBPROTOCOL not in offered and any(_is_secret(name) for name in offered):
            # The answer has to name one that was offered; where there is none to name, all of them would be logged.
            self._note(request, Refusal.MALFORMED)
            raise web.HTTPBadRequest(text=f"beside a token {SUBPROTOCOL} has to be offered\n")
        if self.verifier is None:
            return LOCAL
        by_header = request.headers.getall("Authorization", [])
        if self.is_optional and not tokens and not by_header:
            return LOCAL
        try:
            principal = await self.verifier.verify(_only_token(tokens, by_header))
        except TokenRefused as refused:
            self._note(request, refused.reason, refused.subject)
            raise web.HTTPUnauthorized(text="a valid token is needed\n", headers=_CHALLENGE) from None
        if not by_header and "Origin" not in request.headers:
            # Only browsers cannot set the header, and a browser says whose page it is.
            raise self.other_site(request)
        return principal

    def check_address(self, request: web.Request) -> None:
        """Refuse an address with a token in it, and a name or a page that is not of this gateway.

        Raises:
            web.HTTPBadRequest: a token stands in the address.
            web.HTTPForbidden: the gateway is not called so, or the page is another site's.
        """
        if any(
            name.lower() in _TOKEN_NAMES or _TOKEN.search(f"{name}.{value}") for name, value in request.query.items()
        ):
            self._note(request, Refusal.IN_ADDRESS)
            raise web.HTTPBadRequest(
                text="a token does not belong in an address, where logs keep it: send it in a header\n"
            )
        if not self.rules.answers_to(request.host) and (self.rules.local or request.path not in _PROBED):
            self._note(request, Refusal.HOST)
            raise web.HTTPForbidden(
                text="this gateway has another name: connect by its own, or add this one with --allow-host\n"
            )
        origins = request.headers.getall("Origin", [])
        if len(origins) > 1 or (origins and not self.rules.admits(origins[0], request.host)):
            raise self.other_site(request)

    def other_site(self, request: web.Request) -> web.HTTPException:
        """Record the refusal of a page of another site, and return the answer."""
        self._note(request, Refusal.ORIGIN)
        return web.HTTPForbidden(text="this gateway does not answer pages of that site (--allow-origin)\n")

    def _note(self, request: web.Request, reason: Refusal, subject: str = "") -> None:
        # Nothing that came with the request is repeated: a token can stand anywhere in it.
        self.turned_away(reason.value)
        path = "/adapter" if request.path == "/adapter" else "/"
        stranger = None if not subject else Principal(subject, frozenset(), ())
        audit_rate = self._audit_rates[bool(subject)]
        if audit_rate.admits():
            self.audit.refused(stranger, path, request.remote or "", audit_rate.told(reason.value))
        self._tally.note(f"{path} from {request.remote}: {reason.value}")


def guard(admission: Admission) -> Callable[..., Awaitable[web.StreamResponse]]:
    """Return a middleware that checks the address of every request."""

    @web.middleware
    async def check(
        request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        admission.check_address(request)
        return await handler(request)

    return check


def _is_secret(name: str) -> bool:
    return name.lower().startswith(_BEARER) or _TOKEN.search(name) is not None


def _offered(request: web.Request) -> list[str]:
    lines = request.headers.getall("Sec-WebSocket-Protocol", [])
    return [name.strip(_BLANKS) for line in lines for name in line.split(",")]


def _only_token(by_protocol: list[str], by_header: list[str]) -> str:
    """Return the one token of a request. Raises TokenRefused."""
    if len(by_protocol) + len(by_header) > 1:
        raise TokenRefused(Refusal.MALFORMED)
    if by_protocol:
        return by_protocol[0]
    if not by_header:
        raise TokenRefused(Refusal.MISSING)
    kind, _, token = by_header[0].partition(" ")
    if kind.lower() != "bearer":
        raise TokenRefused(Refusal.MALFORMED)
    return token.strip(_BLANKS)
