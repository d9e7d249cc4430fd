"""Which application holds a component, as the gateway notifies the adapter of it. Pure."""

from openrois.contract import Client
from openrois.types.streams import HolderNotification

__all__ = ["ComponentHolder"]


class ComponentHolder:
    """Follows the notifications of one component. An older epoch takes nothing from a later one.

    Args:
        component_ref: the component; empty: there is none, and no application holds it.

    Attributes:
        client: the application that holds it; None: none does.
    """

    def __init__(self, component_ref: str) -> None:
        self.component_ref = component_ref
        self.client: Client | None = None
        self._epoch = 0

    def apply(self, notification: HolderNotification, client: Client) -> str:
        """Follow a notification; returns why the application that held it does not any more, empty where that stays."""
        if notification.component_ref != self.component_ref:
            return ""
        before = self.client
        if notification.holds:
            if before is None or notification.epoch >= self._epoch:
                self.client, self._epoch = client, notification.epoch
        elif before is client:
            self.client = None
        if before is None or before is self.client:
            return ""
        return "the component was released" if self.client is None else "another application has bound the component"

    def forget_client(self, client: Client) -> bool:
        """Take it from an application that has disconnected; returns whether that held it."""
        held = self.client is client
        if held:
            self.client = None
        return held
