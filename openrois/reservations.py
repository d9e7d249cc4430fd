"""Who holds which component: bind is exclusive, per session, and needed for actuation components only."""

from openrois.errors import OutOfResources

__all__ = ["Reservations"]


class Reservations:
    """The holders of one engine's components. A holder is any object; identity decides."""

    def __init__(self) -> None:
        self._holders: dict[str, object] = {}

    def bind(self, component_ref: str, holder: object) -> None:
        """Reserve a component; binding again what one holds is fine.

        Raises:
            OutOfResources: somebody else holds it.
        """
        if self._holders.setdefault(component_ref, holder) is not holder:
            raise OutOfResources(f"{component_ref} is bound by another application")

    def is_held(self, component_ref: str, holder: object) -> bool:
        """Tell whether `holder` holds the component."""
        return self._holders.get(component_ref) is holder

    def is_held_by_another(self, component_ref: str, holder: object) -> bool:
        """Tell whether somebody holds the component who is not `holder`."""
        return self._holders.get(component_ref, holder) is not holder

    def release(self, component_ref: str, holder: object) -> None:
        """Give a component back; nothing happens if `holder` does not hold it."""
        if self.is_held(component_ref, holder):
            del self._holders[component_ref]

    def release_all(self, holder: object) -> None:
        """Give back everything that `holder` holds."""
        self._holders = {ref: other for ref, other in self._holders.items() if other is not holder}

    def keep_only(self, component_refs: set[str]) -> None:
        """Drop the reservations of components that are no longer there."""
        self._holders = {ref: holder for ref, holder in self._holders.items() if ref in component_refs}
