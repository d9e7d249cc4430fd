"""Many subscriptions to one event of a remote component over one subscription on the other side."""

import asyncio
import secrets
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass, field

from openrois.contract import Event, Sink, SubscriptionLost
from openrois.errors import ComponentFailed, EngineUnreachable
from openrois.types.references import engine_of

__all__ = ["SharedSubscriptions"]

Key = tuple[str, str]
"""A component and an event of it."""


@dataclass(slots=True)
class _Shared:
    """One subscription on the other side; `remote_id` is empty until the other side has answered.

    A `stale` one may have been dropped there, when the engine behind the other side went away and came back.
    """

    key: Key
    sinks: dict[str, Sink] = field(default_factory=dict)
    remote_id: str = ""
    stale: bool = False
    lock: asyncio.Lock = field(default_factory=asyncio.Lock)


class SharedSubscriptions:
    """The sinks of a proxy, by event.

    Args:
        subscribe: subscribes on the other side; calls its second argument with the other side's id as soon as that is
            known, before any event can be read.
        unsubscribe: ends the subscription with the given id on the other side.
        drop: does the same without waiting.
    """

    def __init__(
        self,
        subscribe: Callable[[Key, Callable[[str], None]], Awaitable[None]],
        unsubscribe: Callable[[str], Awaitable[None]],
        drop: Callable[[str], None],
    ) -> None:
        self._subscribe = subscribe
        self._unsubscribe = unsubscribe
        self._drop = drop
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
                if not shared.remote_id or shared.stale:
                    await self._subscribe(key, lambda remote_id: self._register(shared, remote_id))
            if subscribe_id not in self._by_id:
                raise EngineUnreachable("the component went away")
        except BaseException:
            self._drop_sink(shared, subscribe_id)
            self._drop_unheard(shared)
            raise
        return subscribe_id

    def _register(self, shared: _Shared, remote_id: str) -> None:
        if remote_id in self._by_remote_id:
            raise ComponentFailed(f"the engine minted the id {remote_id[:200]!r} twice")
        former, shared.remote_id, shared.stale = shared.remote_id, remote_id, False
        self._by_remote_id[remote_id] = shared
        if former:
            del self._by_remote_id[former]
            self._drop(former)

    def _drop_unheard(self, shared: _Shared) -> None:
        """End a subscription whose caller was gone just when the other side had answered."""
        if shared.remote_id and not shared.sinks and not shared.lock.locked():
            self._by_remote_id.pop(shared.remote_id, None)
            self._drop(shared.remote_id)
            shared.remote_id = ""

    async def remove(self, subscribe_id: str) -> None:
        """Remove a sink, unsubscribing on the other side if it was the last; an unknown id is ignored."""
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
        """Pass an event to every sink of its key."""
        shared = self._by_key.get(key)
        if shared is not None:
            for sink in tuple(shared.sinks.values()):
                sink(event)

    def tree_changed(self, engine_ids: Collection[str] | None = None) -> None:
        """Note that subscriptions may have been dropped on the other side: the next caller subscribes anew.

        Args:
            engine_ids: of components of these engines; None for any.
        """
        for (component_ref, _), shared in self._by_key.items():
            if engine_ids is None or engine_of(component_ref) in engine_ids:
                shared.stale = True

    def keep_only(self, component_refs: Collection[str], notice: SubscriptionLost) -> None:
        """Notify the sinks of components that are no longer there that nothing more will come, and drop them."""
        gone = [shared for shared in self._by_key.values() if shared.key[0] not in component_refs]
        for shared in gone:
            del self._by_key[shared.key]
            if self._by_remote_id.pop(shared.remote_id, None) is not None:
                self._drop(shared.remote_id)
                shared.remote_id = ""
            sinks, shared.sinks = shared.sinks, {}
            for subscribe_id, sink in sinks.items():
                self._by_id.pop(subscribe_id, None)
                sink(notice)

    def lost(self, notice: SubscriptionLost) -> None:
        """Notify every sink that nothing more will come, and drop them."""
        sinks = [sink for shared in self._by_key.values() for sink in shared.sinks.values()]
        self._by_key.clear()
        self._by_remote_id.clear()
        self._by_id.clear()
        for sink in sinks:
            sink(notice)
