"""How long a gateway has been in contact with the store without a break. Pure."""

from typing import Final

__all__ = ["Contact"]

_STEP: Final = 1.0
"""Seconds by which the clocks of store and gateway may differ between two answers; more is a step of one of them."""


class Contact:
    """Answers of the store, judged by the gateway's own monotonic clock.

    Contact begins anew after a failure, after half a time-out without an answer, and where the store's clock was
    stepped: in each case owners may have had no chance to renew.

    Args:
        ttl: seconds for which claims hold after a renewal.
    """

    def __init__(self, ttl: float) -> None:
        self._gap = ttl / 2
        self._since: float | None = None
        self._last = 0.0
        self._last_ms = 0

    def note_answer(self, now: float, store_ms: int) -> None:
        """Note that the store has answered.

        Args:
            now: monotonic seconds of the gateway.
            store_ms: the store's clock in its answer.
        """
        passed, passed_there = now - self._last, (store_ms - self._last_ms) / 1000
        if self._since is None or passed > self._gap or abs(passed - passed_there) > _STEP:
            self._since = now
        self._last, self._last_ms = now, store_ms

    def break_off(self) -> None:
        """Note that the store has not answered."""
        self._since = None

    def lasting(self, now: float) -> float:
        """Return for how many seconds the contact has lasted; 0 where there is none."""
        if self._since is None or now - self._last > self._gap:
            return 0.0
        return now - self._since
