"""The latch of STOP: engines that a person has stopped, until a person hands them back to programs. Pure."""

from collections.abc import Container
from typing import Final

__all__ = ["MAX_AWAY", "StopLatch"]

MAX_AWAY: Final = 1024
"""Stopped engines whose adapter is away that are remembered; of more the one that left first is forgotten."""


class StopLatch:
    """By whom each engine is stopped.

    The adapter of an engine keeps its latch, too, and its word counts when it comes back, because a person may have
    handed the engine back at another gateway meanwhile. One that was restarted has forgotten it, and is told again.
    """

    def __init__(self) -> None:
        self._by: dict[str, str] = {}
        self._away: dict[str, str] = {}
        """The instances of adapters that are away, of engines that are stopped."""

    def __len__(self) -> int:
        return len(self._by)

    def latch(self, engine_id: str, subject: str) -> None:
        """Note that a person has stopped an engine; of several persons the last one is named."""
        self._by[engine_id] = subject
        self._away.pop(engine_id, None)

    def release(self, engine_id: str) -> str:
        """Note that a person has handed an engine back; return who had stopped it, empty text for no person."""
        self._away.pop(engine_id, None)
        return self._by.pop(engine_id, "")

    def by(self, engine_id: str) -> str:
        """Return the person that has stopped an engine for programs; empty text where none has."""
        return self._by.get(engine_id, "")

    def attach(self, engine_id: str, told: str | None, instance: str = "") -> bool:
        """Note that an engine has come.

        Args:
            engine_id: the engine.
            told: the person that has stopped it, as its adapter says; empty for none, None where it keeps no latch.
            instance: of the adapter; empty where it names none.

        Returns:
            Whether the adapter does not know yet that the engine is stopped.
        """
        left = self._away.pop(engine_id, "")
        if told:
            self._by[engine_id] = told
        elif told is not None and instance and instance == left:
            self._by.pop(engine_id, None)
        return engine_id in self._by and told == ""

    def detach(self, engine_id: str, instance: str = "") -> None:
        """Note that the adapter of an engine has gone."""
        if engine_id not in self._by:
            return
        self._away[engine_id] = instance
        if len(self._away) > MAX_AWAY:
            oldest = next(iter(self._away))
            del self._away[oldest], self._by[oldest]

    def of(self, engine_ids: Container[str]) -> dict[str, str]:
        """Return the persons that have stopped some engines, by engine; those that are not stopped are left out."""
        return {engine_id: by for engine_id, by in self._by.items() if engine_id in engine_ids}
