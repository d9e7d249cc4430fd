"""The subscriptions of one client: which id means which, and making them again on the next connection."""

import asyncio
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final, Protocol

from openrois.client.errors import ConnectionLost
from openrois.client.feed import Feed
from openrois.client.notices import Notice, SubscriptionLost, SubscriptionRestored
from openrois.client.rpc_call import Outcome, ask
from openrois.errors import RoISError
from openrois.jsonrpc.session import RpcError, RpcSession
from openrois.types.messages import EventNotification, ReturnResult, SubscribeParams, SubscribeResult, UnsubscribeParams
from openrois.types.model import Model
from openrois.types.references import engine_of

__all__ = ["Entry", "Subscriptions"]

_SUBSCRIBE: Final = "rois.event.subscribe"
_UNSUBSCRIBE: Final = "rois.event.unsubscribe"
_OVERLAP: Final = 1024


class Asker(Protocol):
    """The requests of a connection that subscriptions need."""

    async def ask(
        self,
        method: str,
        params: Model,
        model: type[Outcome],
        accepted: Callable[[Outcome], None] | None = None,
        too_late: Callable[[Outcome], None] | None = None,
    ) -> Outcome:
        """Send a request, on the next connection where one ended."""
        ...

    async def act(self, method: str, params: Model, model: type[Outcome]) -> Outcome:
        """Send a request on this connection or not at all."""
        ...

    def post(self, method: str, params: Model) -> None:
        """Send a request and drop its answer."""
        ...


@dataclass(eq=False)
class Entry:
    """One subscription.

    Attributes:
        event_type, condition: what it is to.
        feed: where its events go.
        subscribe_id: the gateway's name for it; empty while the gateway does not know of it.
        missed: whether the application was notified that it could not be made again.
        interruptions: how often it ended without being asked to.
        renewing: whether it is being made again beside the old one.
        overlap: the events that came by the old one meanwhile, and may come by the new one again.
    """

    event_type: str
    condition: str
    feed: Feed[EventNotification]
    subscribe_id: str = ""
    missed: bool = False
    interruptions: int = 0
    renewing: bool = False
    overlap: set[str] = field(default_factory=set)


class Subscriptions:
    """The subscriptions of one client.

    A lost engine takes its subscriptions with it, and the only sign is that the profile has changed; so they are
    renewed then, all of them where the gateway does not say which engines have changed. The old id counts until the new
    one is there, so that no event is lost, and none is delivered twice.
    """

    def __init__(self, asker: Callable[[], Asker], tell: Callable[[Notice], None]) -> None:
        self._asker = asker
        self._tell = tell
        self._entries: set[Entry] = set()
        self._by_id: dict[str, Entry] = {}

    @property
    def incomplete(self) -> bool:
        """Whether the gateway lacks a subscription that is wanted."""
        return not all(entry.subscribe_id for entry in self._entries)

    async def open(self, entry: Entry) -> None:
        """Subscribe for the first time.

        Raises:
            RoISError: no component has this event, or several do.
            ConnectionLost, TimeoutError: as every question.
        """
        params = SubscribeParams(event_type=entry.event_type, condition=entry.condition)

        def accepted(result: SubscribeResult) -> None:
            self._entries.add(entry)
            self._route(entry, result.subscribe_id)

        def too_late(result: SubscribeResult) -> None:
            if entry.subscribe_id == result.subscribe_id:
                self._drop(entry)
            self._end_late(result)

        await self._asker().ask(_SUBSCRIBE, params, SubscribeResult, accepted, too_late)

    async def close(self, entry: Entry) -> None:
        """Unsubscribe. Events that wait can still be read."""
        subscribe_id = self._drop(entry)
        if subscribe_id:
            try:
                await self._asker().act(_UNSUBSCRIBE, UnsubscribeParams(subscribe_id=subscribe_id), ReturnResult)
            except (ConnectionLost, TimeoutError, RoISError, RpcError):
                # Then it ended with its connection, or will.
                return

    def abandon(self, entry: Entry) -> None:
        """Unsubscribe without waiting, because there is no reader any more."""
        subscribe_id = self._drop(entry)
        if subscribe_id:
            self._asker().post(_UNSUBSCRIBE, UnsubscribeParams(subscribe_id=subscribe_id))

    def deliver(self, notification: EventNotification) -> None:
        """Put an event into its feed; one of a subscription that is over is dropped."""
        entry = self._by_id.get(notification.subscribe_id)
        if entry is None:
            return
        if entry.renewing:
            if len(entry.overlap) < _OVERLAP:
                entry.overlap.add(notification.event_id)
        elif notification.event_id in entry.overlap:
            entry.overlap.discard(notification.event_id)
            return
        entry.feed.offer(notification)

    def lost(self) -> None:
        """Note that the connection has ended, and with it every subscription."""
        self._by_id.clear()
        for entry in self._entries:
            self._interrupt(entry)

    def end_feeds(self, error: Exception | None) -> None:
        """End every feed: the client is closed, or gave up with `error`."""
        for entry in self._entries:
            entry.feed.end_feed(error)

    async def renew(self, session: RpcSession, timeout: float, engine_ids: Collection[str] | None) -> None:
        """Subscribe again to what the gateway does not know of, or engines that have changed may have forgotten.

        Args:
            session: the connection.
            timeout: seconds for each answer.
            engine_ids: these engines; None for any. The id of a subscription begins with that of its engine.

        Raises:
            ConnectionLost: the connection ended.
        """

        def is_doubtful(entry: Entry) -> bool:
            return not entry.subscribe_id or engine_ids is None or engine_of(entry.subscribe_id) in engine_ids

        chosen = [entry for entry in tuple(self._entries) if is_doubtful(entry)]
        await asyncio.gather(*(self._renew(session, timeout, entry) for entry in chosen))

    async def _renew(self, session: RpcSession, timeout: float, entry: Entry) -> None:
        old = entry.subscribe_id
        params = SubscribeParams(event_type=entry.event_type, condition=entry.condition)
        entry.overlap.clear()
        entry.renewing = bool(old)

        def accepted(result: SubscribeResult) -> None:
            entry.renewing = False
            if entry in self._entries:
                self._route(entry, result.subscribe_id)
            else:
                self._end_late(result)

        try:
            await ask(
                session,
                _SUBSCRIBE,
                params,
                SubscribeResult,
                timeout=timeout,
                accepted=accepted,
                too_late=self._end_late,
            )
        except (RoISError, RpcError, TimeoutError) as error:
            entry.renewing = False
            self._missing(entry, error)
        else:
            if old:
                session.post(_UNSUBSCRIBE, {"subscribe_id": old})
            if entry.missed or not old:
                entry.missed = False
                self._tell(SubscriptionRestored(entry.event_type, entry.condition))

    def _route(self, entry: Entry, subscribe_id: str) -> None:
        self._by_id.pop(entry.subscribe_id, None)
        entry.subscribe_id = subscribe_id
        self._by_id[subscribe_id] = entry

    def _missing(self, entry: Entry, error: Exception) -> None:
        self._by_id.pop(entry.subscribe_id, None)
        self._interrupt(entry)
        if not entry.missed and entry in self._entries:
            entry.missed = True
            self._tell(SubscriptionLost(entry.event_type, entry.condition, error))

    @staticmethod
    def _interrupt(entry: Entry) -> None:
        entry.renewing = False
        if entry.subscribe_id:
            entry.interruptions += 1
        entry.subscribe_id = ""

    def _drop(self, entry: Entry) -> str:
        self._entries.discard(entry)
        self._by_id.pop(entry.subscribe_id, None)
        subscribe_id, entry.subscribe_id = entry.subscribe_id, ""
        return subscribe_id

    def _end_late(self, result: SubscribeResult) -> None:
        """End a subscription that was made too late for its caller."""
        self._asker().post(_UNSUBSCRIBE, UnsubscribeParams(subscribe_id=result.subscribe_id))
