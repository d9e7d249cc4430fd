"""The adapter of the soak, a process of its own: arms that move, and tell of it."""

import sys

from openrois.adapter import Component, command, event, query, run

__all__ = ["ARMS", "ENGINE", "Arm"]

ENGINE = "soak"
ARMS = 4


class Arm(Component, authority="OpenRoIS", function="actuation"):
    """An arm that is there at once."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.turns = 0

    @command
    async def turn(self, by: int = 1) -> None:
        """Turn, and tell of it."""
        self.turns += by
        self.turned(self.turns)

    @query
    async def angle(self) -> int:
        """Return how far it has turned."""
        return self.turns

    @event
    def turned(self, turns: int) -> None:
        """It has turned."""


if __name__ == "__main__":
    print(ENGINE, flush=True)
    run(*(Arm(f"arm{number}") for number in range(ARMS)), engine_id=ENGINE, gateway=sys.argv[1])
