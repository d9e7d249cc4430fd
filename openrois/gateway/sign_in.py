"""Sign-ins and sign-outs in the audit trail: the principal, its connection and address, and how it ended."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from openrois.auth.principal import Principal
from openrois.gateway.audit_rate import AuditRate
from openrois.observability.audit import Audit

__all__ = ["SignIns", "Visit"]

RECORDED_AT_ONCE: Final = 2000
"""Sign-ins that the audit trail records one by one, and as many sign-outs: all clients come back after a restart."""

RECORDED_PER_SECOND: Final = 20
"""Of each in the long run; of more the next record says how many there were."""


@dataclass
class Visit:
    """One connection from its sign-in to its sign-out.

    Attributes:
        ended: how it ended, once that is known.
    """

    ended: str = "without a farewell"


class SignIns:
    """Records the connections of a gateway.

    Args:
        audit: the trail.
        clock: monotonic seconds.
    """

    def __init__(self, audit: Audit, clock: Callable[[], float] = time.monotonic) -> None:
        self._audit = audit
        self._in = AuditRate(RECORDED_AT_ONCE, RECORDED_PER_SECOND, clock, "sign-ins")
        self._out = AuditRate(RECORDED_AT_ONCE, RECORDED_PER_SECOND, clock, "sign-outs")

    @contextmanager
    def visit(self, principal: Principal, path: str, address: str) -> Iterator[Visit]:
        """Record that a principal is connected while the block runs.

        Args:
            principal: the principal; a later token of the same subject has a record of its own.
            path: what for: `/` for an application, `/adapter` for an adapter.
            address: where the connection comes from; empty where it comes over no network.
        """
        visit = Visit()
        roles = ", ".join(sorted(role.value for role in principal.roles))
        came = f"signed in as {roles or 'nothing'}" + (f" from {address}" if address else "")
        if self._in.admits():
            self._audit.signed(principal, path, self._in.told(came))
        try:
            yield visit
        finally:
            if self._out.admits():
                self._audit.signed(principal, path, self._out.told(f"signed out: {visit.ended}"))
