"""Fencing: where two gateways claim one adapter, the one with the earlier holder is refused. Pure."""

__all__ = ["EpochFence"]


class EpochFence:
    """The epochs of holders by the parent of the engine that reported them; a parent that has gone counts no more."""

    def __init__(self) -> None:
        self._epochs: dict[object, dict[str, int]] = {}

    def note(self, parent: object, component_ref: str, epoch: int) -> bool:
        """Note the epoch of a holder; tell whether it is at least as new as what any parent has reported."""
        epochs = self._epochs.setdefault(parent, {})
        epochs[component_ref] = max(epoch, epochs.get(component_ref, 0))
        return epoch >= self._latest(component_ref)

    def admits(self, parent: object, component_ref: str) -> bool:
        """Tell whether a command from a parent may run; a parent that reports no holders is not judged."""
        epoch = self._epochs.get(parent, {}).get(component_ref)
        return epoch is None or epoch >= self._latest(component_ref)

    def forget_parent(self, parent: object) -> None:
        """Drop what a parent has reported: its connection has ended."""
        self._epochs.pop(parent, None)

    def _latest(self, component_ref: str) -> int:
        return max((epochs.get(component_ref, 0) for epochs in self._epochs.values()), default=0)
