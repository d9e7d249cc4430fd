"""Which of several gateways an adapter dials next, and when. Pure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from openrois.transport.backoff import Backoff

__all__ = ["LONGEST_WAIT", "Rotation"]

LONGEST_WAIT: Final = 1.0
"""Seconds between two attempts at most while there is no gateway: adapters are back before the applications."""

_FIRST_WAIT: Final = 0.25
_LONGEST_REFUSED: Final = 5.0


def _absent() -> Backoff:
    return Backoff(_FIRST_WAIT, limit=LONGEST_WAIT)


def _refused() -> Backoff:
    return Backoff(limit=_LONGEST_REFUSED)


@dataclass(eq=False)
class _Gateway:
    url: str
    due: float = 0.0
    absent: Backoff = field(default_factory=_absent)
    refused: Backoff = field(default_factory=_refused)


class Rotation:
    """The gateways of an adapter, in an order of its own, so that those of a fleet are spread.

    After one has failed the next is due at once, and each of them only after its own delay: up to 0.25 s, then half as
    long again each time, at most `LONGEST_WAIT`, and by chance less, so that a fleet does not come at once; longer by
    what the gateway asks for. Of one that refuses the adapter it is up to 1 s, later up to 5 s.

    Args:
        urls: their addresses, at least one.
        chance: a number from 0 up to 1.
    """

    def __init__(self, urls: Sequence[str], chance: Callable[[], float]) -> None:
        self._chance = chance
        self._gateways = [_Gateway(url) for url in sorted(dict.fromkeys(urls), key=lambda _url: chance())]
        """The one that is tried next comes first."""

    def next(self, now: float) -> tuple[str, float]:
        """Return the gateway to dial, and the seconds to wait before that."""
        chosen = next((each for each in self._gateways if each.due <= now), None)
        if chosen is None:
            chosen = min(self._gateways, key=lambda each: each.due)
        self._begin_with(chosen)
        return chosen.url, max(0.0, chosen.due - now)

    def failed(self, now: float, *, lasted: float = 0.0, asked: float = 0.0, is_refused: bool = False) -> None:
        """Note how the attempt at the gateway that `next` returned has ended.

        Args:
            now: monotonic seconds.
            lasted: seconds for which there was a connection.
            asked: seconds after which the gateway asks the adapter to come back.
            is_refused: the gateway does not take this adapter; else it is not there, or is there again soon.
        """
        gateway = self._gateways.pop(0)
        backoff = gateway.refused if is_refused else gateway.absent
        gateway.due = now + backoff.after(lasted) * self._chance() + asked
        self._gateways.append(gateway)

    def _begin_with(self, gateway: _Gateway) -> None:
        place = self._gateways.index(gateway)
        self._gateways = self._gateways[place:] + self._gateways[:place]
