"""STUN and TURN servers for both ends of a stream, with credentials that are minted for each and soon expire."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from openrois_signaling.turn import turn_credential

__all__ = ["STUN_TTL", "IceServers"]

STUN_TTL: Final = 3600
"""Seconds for which servers without credentials may be kept."""


@dataclass(frozen=True, slots=True)
class IceServers:
    """The STUN and TURN servers that the gateway names.

    Attributes:
        stun: URLs of STUN servers.
        turn: URLs of TURN servers that share `secret`.
        secret: what credentials are made with.
        turn_ttl: seconds for which they hold.
        wall_clock: epoch seconds.
    """

    stun: Sequence[str]
    turn: Sequence[str]
    secret: str = field(repr=False)
    turn_ttl: int
    wall_clock: Callable[[], float]

    @property
    def ttl(self) -> int:
        """Seconds for which an answer may be kept."""
        return self.turn_ttl if self.turn else STUN_TTL

    def servers(self, user: str) -> tuple[dict[str, Any], ...]:
        """The servers as the W3C's RTCIceServer objects, with credentials for `user`."""
        told: list[dict[str, Any]] = [{"urls": [url]} for url in self.stun]
        if self.turn:
            username, credential = turn_credential(self.secret, int(self.wall_clock()) + self.turn_ttl, user)
            told.append({"urls": list(self.turn), "username": username, "credential": credential})
        return tuple(told)
