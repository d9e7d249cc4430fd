"""Numbers of epochs: each holder of a component has one, and none is greater that is earlier. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from openrois.errors import OutOfResources
from openrois.types.references import engine_of

__all__ = ["ClaimedEpochs", "CountedEpochs", "Epochs"]

_ENOUGH = 0.9
"""Share of a block after which another one is needed soon."""


class Epochs(Protocol):
    """Where the leases of a gateway have their epochs from."""

    def next(self, component_ref: str) -> int:
        """Return the number of an epoch that begins: greater than all that the component has had.

        Raises:
            OutOfResources: there is none left.
        """
        ...

    def attach(self, engine_id: str, seen: int) -> None:
        """Note that an engine has come, and the greatest epoch that its adapter has ever seen; 0 for none."""
        ...

    def detach(self, engine_id: str) -> None:
        """Note that an engine has gone."""
        ...


class CountedEpochs:
    """One counter for all engines: the epochs of a gateway that is alone.

    An adapter that has seen greater epochs, of a gateway whose wall clock was ahead, gets greater ones still.

    Args:
        first: the number of the first epoch.
    """

    def __init__(self, first: int = 1) -> None:
        self._next = first
        self._seen: dict[str, int] = {}

    def next(self, component_ref: str) -> int:
        """Return the number of an epoch that begins."""
        number = self._next
        self._next += 1
        engine_id = engine_of(component_ref)
        seen = self._seen.get(engine_id)
        if seen is not None:
            number = self._seen[engine_id] = max(number, seen + 1)
        return number

    def attach(self, engine_id: str, seen: int) -> None:
        """Note the greatest epoch that the adapter of an engine has seen."""
        if seen >= self._next:
            self._seen[engine_id] = max(seen, self._seen.get(engine_id, 0))

    def detach(self, engine_id: str) -> None:
        """Forget an engine: its adapter says again what it has seen."""
        self._seen.pop(engine_id, None)


@dataclass
class _Block:
    first: int
    last: int
    next: int
    has_asked: bool = False


class ClaimedEpochs:
    """A block of epochs and a counter for each engine that this gateway owns among several.

    Args:
        problem: why no further block can be had now; empty where one can.

    Attributes:
        on_low: called once for each block that is nearly used up, with the engine and the last number of the block.
    """

    def __init__(self, problem: Callable[[], str] = lambda: "") -> None:
        self.on_low: Callable[[str, int], object] = lambda _engine_id, _last: None
        self._problem = problem
        self._blocks: dict[str, _Block] = {}

    def grant(self, engine_id: str, first: int, last: int) -> None:
        """Give an engine a block; one that it has already goes on where it is.

        Args:
            engine_id: the engine.
            first: the first number of the block.
            last: the last number; it belongs to the block.
        """
        known = self._blocks.get(engine_id)
        if known is None or known.first != first:
            self._blocks[engine_id] = _Block(first, last, first)

    @property
    def used_up(self) -> int:
        """Number of engines whose block is used up: they give no leases until they are claimed again."""
        return sum(block.next > block.last for block in self._blocks.values())

    def withdraw(self, engine_id: str) -> None:
        """Take the block of an engine away: this gateway does not own it any more."""
        self._blocks.pop(engine_id, None)

    def next(self, component_ref: str) -> int:
        """Return the number of an epoch that begins.

        Raises:
            OutOfResources: this gateway does not own the engine, or its block is used up.
        """
        engine_id = engine_of(component_ref)
        block = self._blocks.get(engine_id)
        if block is None:
            raise OutOfResources(f"this gateway does not own {engine_id[:200]}, so that it gives no leases there")
        number = block.next
        if not block.has_asked and number - block.first >= _ENOUGH * (block.last - block.first):
            block.has_asked = True
            self.on_low(engine_id, block.last)
        if number > block.last:
            problem = self._problem() or "the claim is being made"
            raise OutOfResources(f"the epochs of {engine_id} are used up until it is claimed again: {problem}")
        block.next += 1
        return number

    def attach(self, engine_id: str, seen: int) -> None:
        """Pass over the epochs of the block that the adapter has seen."""
        block = self._blocks.get(engine_id)
        if block is not None:
            block.next = max(block.next, seen + 1)

    def detach(self, engine_id: str) -> None:
        """Do nothing: a claim, and so its block, may outlast the connection of the adapter."""
