"""The adapter that is measured, a process of its own as any other: one component that answers, and tells on demand."""

import sys
import time

from openrois.adapter import Component, command, event, query, run

__all__ = ["COMPONENT", "ENGINE", "Gauge"]

ENGINE = "bench"
COMPONENT = f"{ENGINE}/gauge"


class Gauge(Component, authority="OpenRoIS", function="sensing"):
    """A gauge that has nothing to do but to answer."""

    @query
    async def level(self) -> float:
        """Return a number, as a sensor would."""
        return 36.6

    @command
    async def announce(self, count: int) -> None:
        """Announce `count` events at once."""
        for _ in range(count):
            self.measured(at=time.monotonic_ns(), level=36.6)

    @event
    def measured(self, at: int, level: float) -> None:
        """The level at a time of this machine's monotonic clock, in nanoseconds."""


if __name__ == "__main__":
    engine_id = sys.argv[2] if len(sys.argv) > 2 else ENGINE
    print(engine_id, flush=True)
    run(Gauge("gauge"), engine_id=engine_id, gateway=sys.argv[1])
