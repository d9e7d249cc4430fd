"""Who holds which component: bind is exclusive, per session, and needed for actuation components only."""

from itertools import count

from openrois.errors import OutOfResources

__all__ = ["Holding"]


class Holding:
    """The holders of one engine's components. A holder is any object; identity decides.

    Each time that somebody else begins to hold a component there is a new epoch, and its number is greater than all
    before it: what was allowed to a former holder can be told from what is allowed to the present one.
    """

    def __init__(self) -> None:
        self._holders: dict[str, object] = {}
        self._epochs: dict[str, int] = {}
        self._numbers = count(1)

    def bind(self, component_ref: str, holder: object) -> int:
        """Reserve a component and return the epoch; binding again what one holds is fine, and begins no new one.

        Raises:
            OutOfResources: somebody else holds it.
        """
        if self._holders.setdefault(component_ref, holder) is not holder:
            raise OutOfResources(f"{component_ref} is bound by another application")
        if component_ref not in self._epochs:
            self._epochs[component_ref] = next(self._numbers)
        return self._epochs[component_ref]

    def is_held(self, component_ref: str, holder: object) -> bool:
        """Tell whether `holder` holds the component."""
        return self._holders.get(component_ref) is holder

    def is_held_by_another(self, component_ref: str, holder: object) -> bool:
        """Tell whether somebody holds the component who is not `holder`."""
        return self._holders.get(component_ref, holder) is not holder

    def release(self, component_ref: str, holder: object) -> int | None:
        """Give a component back and return the epoch that is over; None if `holder` does not hold it."""
        if not self.is_held(component_ref, holder):
            return None
        del self._holders[component_ref]
        return self._epochs.pop(component_ref)

    def release_all(self, holder: object) -> None:
        """Give back everything that `holder` holds."""
        self._keep({ref for ref, other in self._holders.items() if other is not holder})

    def keep_only(self, component_refs: set[str]) -> None:
        """Drop the reservations of components that are no longer there."""
        self._keep(component_refs)

    def _keep(self, component_refs: set[str]) -> None:
        self._holders = {ref: holder for ref, holder in self._holders.items() if ref in component_refs}
        self._epochs = {ref: epoch for ref, epoch in self._epochs.items() if ref in component_refs}
