"""Many subscriptions to one event of a remote component over one subscription on the other side."""

import asyncio
import secrets
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

from openrois.contract import Event, Sink, SubscriptionLost

__all__ = ["SharedSubscriptions"]

Key = tuple[str, str]
"""Whose event, and which."""


@dataclass(slots=True)
class _Shared:
    """One subscription on the other side; `remote_id` is empty until the other side has answered."""

    key: Key
    sinks: dict[str, Sink] = field(default_factory=dict)
    remote_id: str = ""
    lock: asyncio.Lock = field(default_factory=asyncio.Lock)


class SharedSubscriptions:
    """The sinks of a proxy, by event.

    Args:
        subscribe: subscribes on the other side; calls its second argument with the other side's id as soon as that is
            known, before any event can be looked at.
        unsubscribe: ends the subscription with the given id on the other side.
    """

    def __init__(
        self,
        subscribe: Callable[[Key, Callable[[str], None]], Awaitable[None]],
        unsubscribe: Callable[[str], Awaitable[None]],
    ) -> None:
        self._subscribe = subscribe
        self._unsubscribe = unsubscribe
        self._by_key: dict[Key, _Shared] = {}
        self._by_remote_id: dict[str, _Shared] = {}
        self._by_id: dict[str, _Shared] = {}

    async def add(self, key: Key, sink: Sink) -> str:
        """Add a sink, subscribing on the other side if it is the first, and return its id."""
        shared = self._by_key.setdefault(key, _Shared(key))
        subscribe_id = secrets.token_hex(16)
        shared.sinks[subscribe_id] = sink
        self._by_id[subscribe_id] = shared
        try:
            async with shared.lock:
                if not shared.remote_id:
                    await self._subscribe(key, lambda remote_id: self._register(shared, remote_id))
        except BaseException:
            self._drop_sink(shared, subscribe_id)
            raise
        return subscribe_id

    def _register(self, shared: _Shared, remote_id: str) -> None:
        shared.remote_id = remote_id
        self._by_remote_id[remote_id] = shared

    async def remove(self, subscribe_id: str) -> None:
        """Take a sink away, unsubscribing on the other side if it was the last; an unknown id is ignored."""
        shared = self._by_id.get(subscribe_id)
        if shared is None:
            return
        self._drop_sink(shared, subscribe_id)
        async with shared.lock:
            if not shared.sinks and shared.remote_id:
                remote_id, shared.remote_id = shared.remote_id, ""
                self._by_remote_id.pop(remote_id, None)
                await self._unsubscribe(remote_id)

    def _drop_sink(self, shared: _Shared, subscribe_id: str) -> None:
        shared.sinks.pop(subscribe_id, None)
        self._by_id.pop(subscribe_id, None)
        if not shared.sinks and not shared.lock.locked() and self._by_key.get(shared.key) is shared:
            del self._by_key[shared.key]

    def key_of(self, remote_id: str) -> Key | None:
        """Return which event the other side's id stands for, or None."""
        shared = self._by_remote_id.get(remote_id)
        return shared.key if shared is not None else None

    def emit(self, key: Key, event: Event) -> None:
        """Give an event to every sink of its key."""
        shared = self._by_key.get(key)
        if shared is not None:
            for sink in tuple(shared.sinks.values()):
                sink(event)

    def lost(self, notice: SubscriptionLost) -> None:
        """Tell every sink that nothing more will come, and forget them."""
        sinks = [sink for shared in self._by_key.values() for sink in shared.sinks.values()]
        self._by_key.clear()
        self._by_remote_id.clear()
        self._by_id.clear()
        for sink in sinks:
            sink(notice)
