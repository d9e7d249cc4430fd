"""Notifications of holders and STOP to a remote engine; while there is no room, only the latest of each waits."""

from collections.abc import Callable, Mapping
from typing import Any

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.jsonrpc.outbox import Outbox
from openrois.types.stops import StoppedNotification
from openrois.types.streams import HolderNotification

__all__ = ["LeaseOutbox"]


class LeaseOutbox:
    """The holders of components, and what the other side was notified of them.

    However often components change hands, of each at most its former holder's end and its present holder are sent as
    soon as there is room: an adapter that does not read for a moment does not lose its connection by it.

    Args:
        id_of: returns an application's id on the other side, which is notified of its end from then on.
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
        self._now: dict[str, tuple[Client, HolderNotification]] = {}
        self._notified: dict[str, tuple[str, HolderNotification]] = {}
        self._late: dict[str, bool] = {}
        self._stops: dict[str, StoppedNotification] = {}
        self._is_waiting = False

    def put_holder(self, notification: HolderNotification, client: Client) -> None:
        """Send a notification now, or when there is room."""
        component_ref = notification.component_ref
        if notification.holds:
            self._now[component_ref] = client, notification
            self._late.setdefault(component_ref, False)
        elif component_ref in self._now and self._now[component_ref][0] is client:
            del self._now[component_ref]
            self._late[component_ref] = True
        self._send_soon()

    def put_stop(self, notification: StoppedNotification) -> None:
        """Send a notification of STOP now, or when there is room."""
        self._stops[notification.engine_id] = notification
        self._send_soon()

    def _send_soon(self) -> None:
        self.catch_up()
        if self._has_some and not self._is_waiting:
            self._is_waiting = True
            self._tasks.start(self._wait())

    @property
    def _has_some(self) -> bool:
        return bool(self._stops or self._late)

    async def _wait(self) -> None:
        while self._has_some and await self._outbox.room():
            self.catch_up()
        self._is_waiting = False

    def catch_up(self) -> None:
        """Send what waits, as far as there is room."""
        while self._stops and self._outbox.is_roomy:
            notification = self._stops.pop(next(iter(self._stops)))
            self._notify(notification.method, notification.model_dump(mode="json"))
        while self._late and self._outbox.is_roomy:
            component_ref = next(iter(self._late))
            self._send_holder(component_ref, has_ended=self._late.pop(component_ref))

    def _send_holder(self, component_ref: str, *, has_ended: bool) -> None:
        former = self._notified.pop(component_ref, None)
        if former is not None and has_ended:
            self._send(former[0], former[1].model_copy(update={"holds": False}))
        if component_ref in self._now:
            client, notification = self._now[component_ref]
            client_id = self._id_of(client)
            self._notified[component_ref] = client_id, notification
            self._send(client_id, notification)

    def _send(self, client_id: str, notification: HolderNotification) -> None:
        self._notify(notification.method, {**notification.model_dump(mode="json"), "client_id": client_id})

    def forget_client(self, client: Client, client_id: str | None) -> None:
        """Drop what a client held that is gone; the other side is notified of its end anyway."""
        self._now = {ref: held for ref, held in self._now.items() if held[0] is not client}
        self._notified = {ref: sent for ref, sent in self._notified.items() if sent[0] != client_id}

    def clear(self) -> None:
        """Drop everything: the other side is gone."""
        self._now.clear()
        self._notified.clear()
        self._late.clear()
        self._stops.clear()
