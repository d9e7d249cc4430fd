"""Fencing: where two gateways claim one adapter, the one with the earlier holder is refused. Pure."""

__all__ = ["EpochFence"]


class EpochFence:
    """The epochs of holders by the parent of the engine that reported them, and the greatest of each component.

    The greatest stays when the parent that reported it has gone: an earlier gateway, whose connection lasted longer or
    comes later, cannot begin where that one has ended.

    Attributes:
        greatest: of all epochs that were ever reported; 0 for none.
    """

    def __init__(self) -> None:
        self.greatest = 0
        self._greatest: dict[str, int] = {}
        self._reported: dict[object, dict[str, int]] = {}

    def note(self, parent: object, component_ref: str, epoch: int) -> bool:
        """Note the epoch of a holder; tell whether it is at least as new as what any parent has ever reported."""
        reported = self._reported.setdefault(parent, {})
        reported[component_ref] = max(epoch, reported.get(component_ref, 0))
        greatest = self._greatest[component_ref] = max(epoch, self._greatest.get(component_ref, 0))
        self.greatest = max(greatest, self.greatest)
        return epoch >= greatest

    def admits(self, parent: object, component_ref: str) -> bool:
        """Tell whether a command from a parent may run; a parent that reports no holders is not judged."""
        epoch = self._reported.get(parent, {}).get(component_ref)
        return epoch is None or epoch >= self._greatest[component_ref]

    def forget_parent(self, parent: object) -> None:
        """Drop which holders a parent has reported: its connection has ended."""
        self._reported.pop(parent, None)
