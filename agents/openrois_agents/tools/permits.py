"""Permits of a task: the tools that it named, and how often it may move the body. The clock is an argument. Pure."""

from collections.abc import Callable
from typing import Final

from openrois.aio.rate import RateLimit
from openrois.errors import OutOfResources, Unsupported

__all__ = ["Permits"]

_AT_ONCE: Final = 10
_MINUTE: Final = 60.0


class Permits:
    """What a task may do with its body.

    Args:
        tools: the tools that it may use.
        movements: how many it may begin in a minute.
        clock: monotonic seconds.
    """

    def __init__(self, tools: frozenset[str], movements: int, clock: Callable[[], float]) -> None:
        self.tools = tools
        self._movements = movements
        self._rate = RateLimit(min(_AT_ONCE, movements), movements / _MINUTE, clock)

    def require(self, tool: str) -> None:
        """Do nothing where the task may use a tool.

        Raises:
            Unsupported: it did not name it.
        """
        if tool not in self.tools:
            named = ", ".join(sorted(self.tools))
            raise Unsupported(
                f"{tool} is not allowed in this task, which has {named}:"
                f" give_back, then use_body with {tool!r} among its tools"
            )

    def count_movement(self) -> None:
        """Count a movement that begins.

        Raises:
            OutOfResources: there were too many within a minute.
        """
        if not self._rate.admits():
            wait = max(1, round(self._rate.wait()))
            raise OutOfResources(f"more than {self._movements} movements a minute: try again in {wait} s")
