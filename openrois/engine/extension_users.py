"""Where each client has something: the buses whose extension it was passed to. Pure."""

from weakref import WeakKeyDictionary, WeakSet

from openrois.contract import Client, ComponentBus

__all__ = ["ExtensionUsers"]


class ExtensionUsers:
    """Clients and the buses that know them; neither is kept where nothing else refers to it."""

    def __init__(self) -> None:
        self._buses: WeakKeyDictionary[Client, WeakSet[ComponentBus]] = WeakKeyDictionary()

    def note(self, client: Client, bus: ComponentBus) -> None:
        """Note that a bus gets to know a client."""
        self._buses.setdefault(client, WeakSet()).add(bus)

    def forget_client(self, client: Client) -> list[ComponentBus]:
        """Drop a client; return the buses that know it."""
        return list(self._buses.pop(client, ()))
