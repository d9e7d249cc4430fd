"""Holders of components: bind is exclusive, per session, and needed for actuation components only. Pure."""

from collections.abc import Callable, Iterable

from openrois.errors import OutOfResources
from openrois.leases.epochs import CountedEpochs, Epochs

__all__ = ["Holding"]


class Holding:
    """The holders of one engine's components. A holder is any object; identity decides.

    Each time that a component gets another holder there is a new epoch, and its number is greater than all
    before it: what was allowed to a former holder can be told from what is allowed to the present one.

    All held components of a part have the same holder.

    Args:
        epochs: gives their numbers; without it they are counted from 1.
        part_of: the part of a component; each is one by itself unless given.
    """

    def __init__(self, epochs: Epochs | None = None, part_of: Callable[[str], str] = str) -> None:
        self._part_of = part_of
        self._parts: dict[str, str] = {}
        """The part of each component that is held, as it was when that was bound."""
        self._of_part: dict[str, dict[str, None]] = {}
        """The components of each part that are held; an ordered set."""
        self._implied: set[str] = set()
        """Components that their holder has not named: it holds them with others of their part."""
        self._held: dict[str, tuple[object, int]] = {}
        self._of_holder: dict[int, dict[str, int]] = {}
        """The epochs of what each holder has, by its identity."""
        self._epochs = CountedEpochs() if epochs is None else epochs

    def bind(self, component_ref: str, holder: object) -> int:
        """Reserve a component by its name and return the epoch; binding again begins no new one.

        Raises:
            OutOfResources: another holder has it or its part, or there is no epoch left.
        """
        held = self._held.get(component_ref)
        if held is None:
            part = self._part_of(component_ref)
            other = next((ref for ref in self.held_of(part) if self._held[ref][0] is not holder), None)
            if other is not None:
                raise OutOfResources(f"{component_ref} is of the same part as {other}, which another application holds")
            return self.move(component_ref, holder)
        if held[0] is not holder:
            raise OutOfResources(f"{component_ref} is bound by another application")
        self._implied.discard(component_ref)
        return held[1]

    def next_epoch(self, component_ref: str) -> int:
        """Return the number of an epoch of a component, for `move`.

        Raises:
            OutOfResources: there is none left.
        """
        return self._epochs.next(component_ref)

    def move(self, component_ref: str, holder: object, epoch: int | None = None, *, is_implied: bool = False) -> int:
        """Make `holder` the only holder of a component; return the epoch that begins.

        Args:
            component_ref: the component.
            holder: has it from now on.
            epoch: of `next_epoch`; the next one unless given.
            is_implied: whether the holder has it with others of its part, and has not named it.

        Raises:
            OutOfResources: there is no epoch left, and nothing has changed.
        """
        if epoch is None:
            epoch = self.next_epoch(component_ref)
        former = self._held.get(component_ref)
        if former is not None:
            self._remove(component_ref, former[0])
        self._add(component_ref, holder, epoch)
        if is_implied:
            self._implied.add(component_ref)
        return epoch

    def _add(self, component_ref: str, holder: object, epoch: int) -> None:
        self._held[component_ref] = holder, epoch
        part = self._parts[component_ref] = self._part_of(component_ref)
        self._of_part.setdefault(part, {})[component_ref] = None
        self._of_holder.setdefault(id(holder), {})[component_ref] = epoch

    def _remove(self, component_ref: str, holder: object) -> None:
        del self._held[component_ref]
        self._implied.discard(component_ref)
        part = self._parts.pop(component_ref)
        del self._of_part[part][component_ref]
        if not self._of_part[part]:
            del self._of_part[part]
        held = self._of_holder[id(holder)]
        del held[component_ref]
        if not held:
            del self._of_holder[id(holder)]

    def holder(self, component_ref: str) -> tuple[object, int] | None:
        """Return the holder of the component and the epoch, or None where it is free."""
        return self._held.get(component_ref)

    def part_of(self, component_ref: str) -> str:
        """Return the part of a component; of one that is held the part in which it is held."""
        return self._parts.get(component_ref) or self._part_of(component_ref)

    def held_of(self, part: str) -> tuple[str, ...]:
        """Return the components of a part that are held."""
        return tuple(self._of_part.get(part, ()))

    def is_implied(self, component_ref: str) -> bool:
        """Tell whether the holder of a component has it only with others of its part."""
        return component_ref in self._implied

    def named_of(self, part: str) -> tuple[str, ...]:
        """Return the components of a part that its holder has named."""
        return tuple(ref for ref in self._of_part.get(part, ()) if ref not in self._implied)

    def holder_of(self, part: str) -> object | None:
        """Return the session that holds a part, or some of it; None where it is free."""
        return next((self._held[ref][0] for ref in self._of_part.get(part, ())), None)

    def moved(self, component_refs: Iterable[str]) -> list[str]:
        """Return those of some components that are held, and belong to another part by now."""
        return [ref for ref in component_refs if ref in self._parts and self._parts[ref] != self._part_of(ref)]

    def parts_of(self, holder: object) -> tuple[str, ...]:
        """Return the parts of which `holder` holds something."""
        return tuple(dict.fromkeys(self._parts[ref] for ref in self._of_holder.get(id(holder), ())))

    def is_held(self, component_ref: str, holder: object) -> bool:
        """Tell whether `holder` holds the component."""
        held = self._held.get(component_ref)
        return held is not None and held[0] is holder

    def is_held_by_another(self, component_ref: str, holder: object) -> bool:
        """Tell whether the component, or its part, has a holder other than `holder`."""
        held = self._held.get(component_ref)
        other = self.holder_of(self._part_of(component_ref)) if held is None else held[0]
        return other is not None and other is not holder

    def held_by(self, holder: object) -> dict[str, int]:
        """Return the epochs of what `holder` holds, by component_ref."""
        return dict(self._of_holder.get(id(holder), {}))

    def held(self) -> frozenset[str]:
        """Return every component that is held."""
        return frozenset(self._held)

    def release(self, component_ref: str, holder: object) -> int | None:
        """Release a component and return the epoch that is over; None if `holder` does not hold it."""
        if not self.is_held(component_ref, holder):
            return None
        epoch = self._held[component_ref][1]
        self._remove(component_ref, holder)
        return epoch

    def succeed(self, component_ref: str, successor: object) -> None:
        """Make a successor the holder in the same epoch."""
        former, epoch = self._held[component_ref]
        is_implied = self.is_implied(component_ref)
        self._remove(component_ref, former)
        self.move(component_ref, successor, epoch, is_implied=is_implied)
