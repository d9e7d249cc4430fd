"""The subscriptions of one application and the details of the events that it received."""

import asyncio
import json
import logging
import time
from collections.abc import Callable, Container, Coroutine, Iterator
from dataclasses import dataclass, field
from datetime import UTC
from typing import Any, Final, Protocol

from openrois.aio.bounded_history import BoundedHistory
from openrois.aio.lean_queue import LeanQueue
from openrois.contract import Event, EventText, SubscriptionLost
from openrois.engine.engine import Engine
from openrois.errors import BadParameter, EngineUnreachable, OutOfResources
from openrois.jsonrpc.session import Reply
from openrois.types.messages import Result, SubscribeResult
from openrois.types.references import engine_of, new_id
from openrois.types.streams import StreamStatusNotification
from openrois.types.values import date_time, read_date_time

__all__ = ["EventLog"]

_log = logging.getLogger(__name__)

MAX_SUBSCRIPTIONS: Final = 1024
MAX_DETAILS: Final = 1024
MAX_HELD: Final = 256
DETAIL_LIFETIME: Final = 60.0
MAX_DATE_TIME: Final = 64
"""Characters of an event's `expire`; a longer text is no DateTime anyway."""

_STATUS_EVENT: Final = "notify_stream_status"


@dataclass(eq=False, slots=True)
class _Subscription:
    """One subscription; events that come before its reply has left are held back until then."""

    subscribe_id: str
    component_ref: str
    event_type: str
    bus_id: str = ""
    open: bool = False
    dropped: bool = False
    held: LeanQueue[Event] = field(default_factory=LeanQueue)
    as_json: str = field(init=False)

    def __post_init__(self) -> None:
        self.as_json = json.dumps(self.subscribe_id)


@dataclass(slots=True)
class _Notified:
    """A notified event, and when that was, by both clocks."""

    text: EventText
    component_ref: str
    expire: str
    at: float
    wall: float


class Timer(Protocol):
    """Something that will be done."""

    def cancel(self) -> None:
        """Do it no more."""
        ...


def _later(seconds: float, act: Callable[[], None]) -> Timer:
    return asyncio.get_running_loop().call_later(seconds, act)


class EventLog:
    """The subscriptions of one application, and the events whose details it may read.

    Args:
        engine: that is subscribed to.
        notify: sends a notification.
        clock: monotonic seconds.
        wall_clock: epoch seconds.
        later: does something after some seconds.
    """

    def __init__(
        self,
        engine: Engine,
        notify: Callable[..., None],
        clock: Callable[[], float] = time.monotonic,
        wall_clock: Callable[[], float] = time.time,
        later: Callable[[float, Callable[[], None]], Timer] = _later,
    ) -> None:
        self._engine = engine
        self._notify = notify
        self._clock = clock
        self._wall_clock = wall_clock
        self._subscriptions: dict[str, _Subscription] = {}
        self._details: BoundedHistory[_Notified] = BoundedHistory(MAX_DETAILS)
        self._later = later
        self._forgetting: Timer | None = None

    def count(self) -> int:
        """Return how many subscriptions there are."""
        return len(self._subscriptions)

    async def subscribe(self, component_ref: str, event_type: str, *, of_streams: bool) -> Reply:
        """Subscribe and return the reply, after which events flow.

        Args:
            component_ref: whose event.
            event_type: which event.
            of_streams: the component's engine tells each application about its own streams, so that no subscription
                of its own is needed and none sees another's streams.

        Raises:
            OutOfResources: the application has too many subscriptions.
            RoISError: the component refused.
        """
        if len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
            raise OutOfResources(f"one application has at most {MAX_SUBSCRIPTIONS} subscriptions")
        subscription = _Subscription(new_id(engine_of(component_ref)), component_ref, event_type)
        self._subscriptions[subscription.subscribe_id] = subscription
        if not (of_streams and event_type == _STATUS_EVENT):
            await self._listen(subscription)
        return Reply(SubscribeResult(subscribe_id=subscription.subscribe_id), lambda: self._open(subscription))

    async def _listen(self, subscription: _Subscription) -> None:
        try:
            subscription.bus_id = await self._engine.subscribe(
                subscription.component_ref, subscription.event_type, lambda item: self._handle_item(subscription, item)
            )
        except BaseException:
            self._subscriptions.pop(subscription.subscribe_id, None)
            raise
        if subscription.subscribe_id not in self._subscriptions:
            # The engine was lost, or the application left, while the component took the subscription.
            await self._engine.unsubscribe(subscription.bus_id)
            raise EngineUnreachable("the subscription ended before it began")

    async def unsubscribe(self, subscribe_id: str) -> None:
        """End a subscription; an unknown id is ignored."""
        subscription = self._subscriptions.pop(subscribe_id, None)
        if subscription is not None and subscription.bus_id:
            await self._engine.unsubscribe(subscription.bus_id)

    def clear(self) -> Coroutine[Any, Any, None]:
        """Drop every subscription at once, so that no later one is included; return what ends them at the engine."""
        former, self._subscriptions = self._subscriptions, {}
        return self._unsubscribe_all([subscription.bus_id for subscription in former.values() if subscription.bus_id])

    async def _unsubscribe_all(self, bus_ids: list[str]) -> None:
        """End subscriptions at the engine; one that cannot be ended properly does not keep the others."""
        ending = (self._engine.unsubscribe(bus_id) for bus_id in bus_ids)
        for outcome in await asyncio.gather(*ending, return_exceptions=True):
            if isinstance(outcome, Exception):
                _log.info("a subscription could not be ended: %s", outcome)

    def keep_only(self, component_refs: Container[str]) -> None:
        """Drop subscriptions to own streams of components that are no longer there; others are ended by their bus."""
        for subscription in tuple(self._subscriptions.values()):
            if not subscription.bus_id and subscription.component_ref not in component_refs:
                del self._subscriptions[subscription.subscribe_id]

    def drop(self, is_lost: Callable[[str], bool]) -> Coroutine[Any, Any, None]:
        """Drop at once the subscriptions to components that are lost to the application; return what ends them."""
        dropped = [s for s in self._subscriptions.values() if is_lost(s.component_ref)]
        for subscription in dropped:
            del self._subscriptions[subscription.subscribe_id]
            subscription.open, subscription.dropped = False, True
        return self._unsubscribe_all([subscription.bus_id for subscription in dropped if subscription.bus_id])

    def sources(self) -> Iterator[str]:
        """Yield the component of each open subscription."""
        return (each.component_ref for each in self._subscriptions.values() if each.open)

    def details(self, event_id: str, sees: Callable[[str], bool] = lambda _component_ref: True) -> tuple[Result, ...]:
        """Return the results of an event that this application received.

        Args:
            event_id: the event.
            sees: tells whether the component that it is of is in the application's scope, which may have changed.

        Raises:
            BadParameter: it never received it, or too long ago, or it is out of scope by now.
        """
        told = self._details.get(event_id)
        if told is None or self._is_over(told) or not sees(told.component_ref):
            raise BadParameter(f"there are no details of an event {event_id[:200]!r}")
        return told.text.results()

    def _forget_expired(self) -> None:
        """Forget the details that have expired, and look again later while others are left."""
        self._details.drop_oldest(self._is_over)
        self._forgetting = self._later(DETAIL_LIFETIME, self._forget_expired) if self._details else None

    def close(self) -> None:
        """Do nothing later any more: there is no application that could ask."""
        if self._forgetting is not None:
            self._forgetting.cancel()

    def _is_over(self, told: _Notified) -> bool:
        """Tell whether the details have expired: at `expire`, or a while after the notification.

        How long that is was settled at the notification: the wall clock may have been set since.
        """
        try:
            expire = read_date_time(told.expire[:MAX_DATE_TIME])
        except ValueError:
            return self._clock() >= told.at + DETAIL_LIFETIME
        if expire.tzinfo is None:
            expire = expire.replace(tzinfo=UTC)
        return self._clock() >= told.at + expire.timestamp() - told.wall

    def stream_status(self, notice: StreamStatusNotification) -> None:
        """Turn a status notification of an own stream into the event, for each subscription to it."""
        component_ref = notice.component_ref
        results = (
            Result(name="timestamp", data_type_ref="DateTime", value=notice.timestamp),
            Result(name="status", data_type_ref="Stream_Status", value=notice.status.value),
            Result(name="stream_id", data_type_ref="string", value=notice.stream_id),
        )
        expire = date_time(self._wall_clock() + DETAIL_LIFETIME)
        event = Event(new_id(engine_of(component_ref)), _STATUS_EVENT, component_ref, expire, results)
        for subscription in tuple(self._subscriptions.values()):
            if subscription.event_type == _STATUS_EVENT and subscription.component_ref == component_ref:
                self._handle_item(subscription, event)

    def _open(self, subscription: _Subscription) -> None:
        if subscription.dropped:
            return
        subscription.open = True
        while subscription.held:
            self._send_event(subscription, subscription.held.pop())

    def _handle_item(self, subscription: _Subscription, item: Event | SubscriptionLost) -> None:
        if isinstance(item, SubscriptionLost):
            self._subscriptions.pop(subscription.subscribe_id, None)
        elif subscription.open:
            self._send_event(subscription, item)
        else:
            if len(subscription.held) >= MAX_HELD:
                subscription.held.pop()
            subscription.held.put(item)

    def _send_event(self, subscription: _Subscription, event: Event) -> None:
        told = _Notified(event.text, event.component_ref, event.expire, self._clock(), self._wall_clock())
        self._details.put(event.event_id, told, event.results)
        if self._forgetting is None:
            self._forgetting = self._later(DETAIL_LIFETIME, self._forget_expired)
        self._notify("rois.event.notify_event", event.text.params_for(subscription.as_json), droppable=True)
