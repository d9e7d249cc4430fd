"""Fencing: where two gateways believe to be in charge of one adapter, the one with the earlier holder is refused."""

__all__ = ["EpochFence"]


class EpochFence:
    """The epochs of holders, as the parents of an engine told them; a parent that has gone counts no more."""

    def __init__(self) -> None:
        self._epochs: dict[object, dict[str, int]] = {}

    def note(self, parent: object, component_ref: str, epoch: int) -> bool:
        """Note the epoch of a holder; tell whether it is not older than what another parent has told, or this one."""
        epochs = self._epochs.setdefault(parent, {})
        epochs[component_ref] = max(epoch, epochs.get(component_ref, 0))
        return epoch >= self._latest(component_ref)

    def admits(self, parent: object, component_ref: str) -> bool:
        """Tell whether a command from a parent may run; one that tells of no holders is not judged."""
        epoch = self._epochs.get(parent, {}).get(component_ref)
        return epoch is None or epoch >= self._latest(component_ref)

    def forget(self, parent: object) -> None:
        """Forget a parent: nothing comes from there any more."""
        self._epochs.pop(parent, None)

    def _latest(self, component_ref: str) -> int:
        return max((epochs.get(component_ref, 0) for epochs in self._epochs.values()), default=0)
