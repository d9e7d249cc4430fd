"""The latch of STOP: engines that a person has stopped, until a person hands them back to programs. Pure."""

from collections.abc import Container
from dataclasses import dataclass
from typing import Final

__all__ = ["MAX_AWAY", "StopLatch"]

MAX_AWAY: Final = 1024
"""Stopped engines whose adapter is away that are remembered; of more the one that left first is forgotten."""


@dataclass(frozen=True, slots=True)
class _Stop:
    """A STOP that holds: by whom, and its id, which is empty where its adapter knows none."""

    by: str = ""
    stop_id: str = ""


_NONE: Final = _Stop()


class StopLatch:
    """By whom each engine is stopped.

    The adapter of an engine keeps its latch, too, and its word counts when it comes back, because a person may have
    handed the engine back at another gateway meanwhile. One that was restarted has forgotten it, and is told again.
    """

    def __init__(self) -> None:
        self._stops: dict[str, _Stop] = {}
        self._away: dict[str, str] = {}
        """The instances of adapters that are away, of engines that are stopped."""

    def __len__(self) -> int:
        return len(self._stops)

    def latch(self, engine_id: str, subject: str, stop_id: str = "") -> None:
        """Note that a person has stopped an engine; of several persons the last one is named."""
        self._stops[engine_id] = _Stop(subject, stop_id)
        self._away.pop(engine_id, None)

    def release(self, engine_id: str) -> str:
        """Note that a person has handed an engine back; return who had stopped it, empty text for no person."""
        self._away.pop(engine_id, None)
        return self._stops.pop(engine_id, _NONE).by

    def by(self, engine_id: str) -> str:
        """Return the person that has stopped an engine for programs; empty text where none has."""
        return self._stops.get(engine_id, _NONE).by

    def stop_id(self, engine_id: str) -> str:
        """Return the id of the STOP that holds; empty where none does, or it has none."""
        return self._stops.get(engine_id, _NONE).stop_id

    def may_be(self, engine_id: str, stop_id: str) -> bool:
        """Tell whether the STOP that holds may be the one of an id: where one of them has no id, it may."""
        return not stop_id or self.stop_id(engine_id) in ("", stop_id)

    def attach(self, engine_id: str, told: str | None, instance: str = "", stop_id: str = "") -> bool:
        """Note that an engine has come.

        Args:
            engine_id: the engine.
            told: the person that has stopped it, as its adapter says; empty for none, None where it keeps no latch.
            instance: of the adapter; empty where it names none.
            stop_id: of that person's STOP.

        Returns:
            Whether the adapter does not know yet that the engine is stopped.
        """
        left = self._away.pop(engine_id, "")
        if told:
            self._stops[engine_id] = _Stop(told, stop_id)
        elif told is not None and instance and instance == left:
            self._stops.pop(engine_id, None)
        return engine_id in self._stops and told == ""

    def detach(self, engine_id: str, instance: str = "") -> None:
        """Note that the adapter of an engine has gone."""
        if engine_id not in self._stops:
            return
        self._away[engine_id] = instance
        if len(self._away) > MAX_AWAY:
            oldest = next(iter(self._away))
            del self._away[oldest], self._stops[oldest]

    def of(self, engine_ids: Container[str]) -> dict[str, str]:
        """Return the persons that have stopped some engines, by engine; those that are not stopped are left out."""
        return {engine_id: stop.by for engine_id, stop in self._stops.items() if engine_id in engine_ids}
