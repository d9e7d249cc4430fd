"""Consent of one visitor by purpose: what may be used now, and since when. Pure; time is an argument."""

import math
from collections.abc import Collection
from collections.abc import Set as AbstractSet
from typing import Final

from openrois.types.codes import Purpose

__all__ = ["UNSTATED", "Consent"]

UNSTATED: Final = frozenset({Purpose.LIVE, Purpose.RECOGNITION})
"""Consent of a sender that states none, which only an operator may be: to what was done before there were visitors."""


class Consent:
    """Purposes that a visitor consents to; none before the first statement.

    Something that was captured is admitted for a purpose if the consent to it has held ever since: what was captured
    before a withdrawal is never admitted again, also after a new consent.
    """

    def __init__(self) -> None:
        self._since: dict[Purpose, float] = {}
        self._was_stated = False

    @property
    def purposes(self) -> frozenset[Purpose]:
        """The purposes that are consented to now."""
        return frozenset(self._since)

    def state(self, purposes: Collection[Purpose], now: float) -> frozenset[Purpose]:
        """Consent to these purposes and to no other; return those that are withdrawn by that.

        Args:
            purposes: all purposes.
            now: seconds of the clock of capture times. The first statement, which comes before the first media, holds
                for all of them, however their capture times are estimated.
        """
        withdrawn = self.purposes.difference(purposes)
        since = now if self._was_stated else -math.inf
        self._since = {purpose: self._since.get(purpose, since) for purpose in purposes}
        self._was_stated = True
        return withdrawn

    def holds(self, purposes: AbstractSet[Purpose]) -> bool:
        """Tell whether all of these purposes, at least one, are consented to now."""
        return bool(purposes) and purposes <= self._since.keys()

    def admits(self, purposes: AbstractSet[Purpose], captured_at: float) -> bool:
        """Tell whether what was captured then may be used now for all of these purposes, which are at least one."""
        return self.holds(purposes) and all(self._since[each] <= captured_at for each in purposes)
