"""Liveness and readiness of a gateway or an adapter for probes; the reasons are for the operator alone."""

import hmac
from collections.abc import Callable
from typing import Final

from aiohttp import web

from openrois.auth.loopback import is_loopback

__all__ = ["Readiness", "healthz", "readyz"]

_PASSED_ON: Final = ("Forwarded", "X-Forwarded-For", "X-Real-IP", "Via")


class Readiness:
    """Conditions under which a gateway takes new connections, or an adapter is behind its gateway."""

    def __init__(self) -> None:
        self._checks: dict[str, Callable[[], bool]] = {}

    def require(self, what: str, holds: Callable[[], bool]) -> None:
        """Add a condition `holds`, which must not block; `what` is named where it does not hold."""
        self._checks[what] = holds

    def lacking(self) -> list[str]:
        """Return what does not hold now."""
        return [what for what, holds in self._checks.items() if not holds()]


async def healthz(_request: web.Request) -> web.Response:
    """Answer that the event loop turns: a process manager that gets no answer in time may restart the process."""
    return web.json_response({"status": "ok"})


async def readyz(readiness: Readiness, token: str, request: web.Request) -> web.Response:
    """Answer 200 or 503; a client of this machine or with the token of the figures also gets the reasons."""
    lacking = readiness.lacking()
    told: dict[str, object] = {"status": "not ready" if lacking else "ready"}
    if lacking and _may_know(request, token):
        told["lacking"] = lacking
    return web.json_response(told, status=503 if lacking else 200)


def _may_know(request: web.Request, token: str) -> bool:
    shown = request.headers.get("Authorization", "")
    if token and hmac.compare_digest(shown.encode(errors="surrogateescape"), f"Bearer {token}".encode()):
        return True
    # What a proxy of this machine passes on comes from anywhere.
    return is_loopback(request.remote or "") and not any(name in request.headers for name in _PASSED_ON)
