"""Telling a remote engine who holds its components: where much waits to be sent, of each no more than how it stands."""

from collections.abc import Callable, Mapping
from typing import Any

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.jsonrpc.outbox import Outbox
from openrois.types.streams import HolderNotification

__all__ = ["LeaseOutbox"]


class LeaseOutbox:
    """Who holds what, and what the other side was told of it.

    However often components change hands, of each at most its former holder's end and its present holder are told as
    soon as there is room: an adapter that does not read for a moment does not lose its connection by it.

    Args:
        id_of: returns an application's id on the other side, which hears of its end from then on.
        notify: tells the other side.
        outbox: what waits to be sent there.
        tasks: owns the waiting for room.
    """

    def __init__(
        self,
        id_of: Callable[[Client], str],
        notify: Callable[[str, Mapping[str, Any]], None],
        outbox: Outbox,
        tasks: TaskScope,
    ) -> None:
        self._id_of = id_of
        self._notify = notify
        self._outbox = outbox
        self._tasks = tasks
        self._now: dict[str, tuple[Client, Mapping[str, Any]]] = {}
        self._told: dict[str, Mapping[str, Any]] = {}
        self._late: dict[str, bool] = {}
        self._is_waiting = False

    def take(self, params: Mapping[str, Any], client: Client) -> None:
        """Take the params of `openrois.holder`, and tell them now or when there is room."""
        component_ref = params["component_ref"]
        if params["holds"]:
            self._now[component_ref] = client, params
            self._late.setdefault(component_ref, False)
        elif component_ref in self._now and self._now[component_ref][0] is client:
            del self._now[component_ref]
            self._late[component_ref] = True
        self.catch_up()
        if self._late and not self._is_waiting:
            self._is_waiting = True
            self._tasks.start(self._wait())

    async def _wait(self) -> None:
        while self._late and await self._outbox.room():
            self.catch_up()
        self._is_waiting = False

    def catch_up(self) -> None:
        """Tell what has not been told, as far as there is room."""
        while self._late and self._outbox.is_roomy:
            component_ref = next(iter(self._late))
            self._tell(component_ref, has_ended=self._late.pop(component_ref))

    def _tell(self, component_ref: str, *, has_ended: bool) -> None:
        former = self._told.pop(component_ref, None)
        if former is not None and has_ended:
            self._notify(HolderNotification.method, {**former, "holds": False})
        if component_ref in self._now:
            client, params = self._now[component_ref]
            told = self._told[component_ref] = {**params, "client_id": self._id_of(client)}
            self._notify(HolderNotification.method, told)

    def forget(self, client: Client, client_id: str | None) -> None:
        """Drop what an application held that is gone; the other side hears of the end of what it was told anyway."""
        self._now = {ref: held for ref, held in self._now.items() if held[0] is not client}
        self._told = {ref: told for ref, told in self._told.items() if told["client_id"] != client_id}

    def clear(self) -> None:
        """Forget everything: the other side is gone."""
        self._now.clear()
        self._told.clear()
        self._late.clear()
