"""Which gateways are there, by their signs of life. The clock is an argument. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from openrois.cluster.frames import Beat

__all__ = ["BEAT_INTERVAL", "MAX_GATEWAYS", "RANKS", "SILENCE", "Presence", "Present"]

BEAT_INTERVAL: Final = 0.25
"""Seconds between two signs of life."""

SILENCE: Final = 1.0
"""Seconds without a sign of life after which a gateway is gone."""

MAX_GATEWAYS: Final = 1024
"""Connections that are remembered: more signs of life are not heard."""

RANKS: Final = "ranks"
"""Attribute of a gateway: the ranks that it knows, as one text with commas."""


@dataclass(frozen=True, slots=True)
class Present:
    """A gateway that is there.

    Attributes:
        gateway_id: its id.
        instance: the token of its process: another one after a restart.
        link: the token of its connection to NATS.
        version: of its program.
        attributes: what it tells all others.
    """

    gateway_id: str
    instance: str
    link: str
    version: str
    attributes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(slots=True)
class _Heard:
    at: float
    gateway: Present | None = None


class Presence:
    """Signs of life of connections, and so of gateways.

    Args:
        clock: monotonic seconds.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._heard: dict[str, _Heard] = {}
        self.present: Mapping[str, Present] = MappingProxyType({})
        """The gateways that are there, by id."""

    def __contains__(self, link: str) -> bool:
        return link in self._heard

    def handle_beat(self, beat: Beat) -> bool:
        """Note a sign of life, and tell whether a connection is gone by what it says."""
        if beat.leaving:
            return self._remove({beat.link})
        known = self.present.get(beat.gateway)
        gateway = Present(beat.gateway, beat.instance, beat.link, beat.version, beat.attributes)
        if self.note_sign(beat.link) and known != gateway:
            self._heard[beat.link].gateway = gateway
            # A process has one connection at a time.
            is_former = known is not None and known.instance == beat.instance and known.link != beat.link
            return self._remove({known.link} if known is not None and is_former else set())
        return False

    def note_sign(self, link: str) -> bool:
        """Note that something came from a connection, and tell whether it is known now: there may be too many."""
        heard = self._heard.get(link)
        if heard is not None:
            heard.at = self._clock()
        elif len(self._heard) < MAX_GATEWAYS:
            self._heard[link] = _Heard(self._clock())
        return link in self._heard

    def expire(self) -> bool:
        """Let connections go that have been silent for too long, and tell whether there was one."""
        now = self._clock()
        return self._remove({link for link, heard in self._heard.items() if now >= heard.at + SILENCE})

    def excuse(self) -> None:
        """Count all as heard now: the listener itself stood still, and what they said waits unread."""
        now = self._clock()
        for heard in self._heard.values():
            heard.at = now

    def clear(self) -> None:
        """Count all as gone: there is no connection over which they could be heard."""
        self._remove(set(self._heard))

    @property
    def next_expiry(self) -> float:
        """When the next connection is gone unless it is heard before."""
        return min((heard.at for heard in self._heard.values()), default=self._clock()) + SILENCE

    def _remove(self, links: set[str]) -> bool:
        gone = [link for link in links if self._heard.pop(link, None) is not None]
        # Of two connections of a gateway the one that was heard last stands for it.
        latest = sorted(self._heard.values(), key=lambda heard: heard.at)
        present = {heard.gateway.gateway_id: heard.gateway for heard in latest if heard.gateway is not None}
        if present != self.present:
            self.present = MappingProxyType(present)
        return bool(gone)
