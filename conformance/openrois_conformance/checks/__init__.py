"""Checks from outside, by area."""

from typing import Final

from openrois_conformance.checks import (
    adapters,
    command,
    components,
    directory,
    envelope,
    event,
    execute,
    leases,
    query,
    reasons,
    streams,
    system,
    tokens,
    transport,
)
from openrois_conformance.stage import Check

__all__ = ["ALL_CHECKS"]

ALL_CHECKS: Final[tuple[Check, ...]] = (
    *transport.CHECKS,
    *envelope.CHECKS,
    *system.CHECKS,
    *command.CHECKS,
    *execute.CHECKS,
    *query.CHECKS,
    *event.CHECKS,
    *components.CHECKS,
    *adapters.CHECKS,
    *directory.CHECKS,
    *streams.CHECKS,
    *reasons.CHECKS,
    *leases.CHECKS,
    *tokens.CHECKS,
)
