"""Making bindings and subscriptions again, for as long as something is missing."""

import asyncio
from collections.abc import Collection
from contextlib import suppress
from typing import Literal

from openrois.client.bindings import Bindings
from openrois.client.errors import ConnectionLost
from openrois.client.reconnect import Reconnect
from openrois.client.subscriptions import Subscriptions
from openrois.jsonrpc.session import RpcSession

__all__ = ["Restorer"]


class Restorer:
    """Keeps bindings and subscriptions at a gateway as the application wants them.

    What an engine that has changed was asked for is renewed: it may have left and come back, and have forgotten it.
    What is missing is tried again after a while: RoIS has no notification that a component was given back, or works
    again.
    """

    def __init__(
        self, bindings: Bindings, subscriptions: Subscriptions, reconnect: Reconnect, request_timeout: float
    ) -> None:
        self._bindings = bindings
        self._subscriptions = subscriptions
        self._reconnect = reconnect
        self._timeout = request_timeout
        self._changed = asyncio.Event()
        self._engine_ids: set[str] | None = set()

    def profile_changed(self, engine_ids: Collection[str] = ()) -> None:
        """Note that these engines have changed; of any where none is named."""
        if not engine_ids:
            self._engine_ids = None
        elif self._engine_ids is not None:
            self._engine_ids.update(engine_ids)
        self._changed.set()

    async def run(self, session: RpcSession) -> None:
        """Work on a new connection until it ends; what was bound is bound again already, see `Bindings.renew`."""
        backoff = self._reconnect.backoff()
        with suppress(ConnectionLost):
            await self._subscriptions.renew(session, self._timeout, frozenset())
            while True:
                incomplete = self._bindings.incomplete or self._subscriptions.incomplete
                changed = await self._changed_within(backoff.after(0) if incomplete else None)
                if changed:
                    backoff = self._reconnect.backoff()
                engine_ids, self._engine_ids = self._engine_ids, set()
                await self._bindings.renew(session, self._timeout)
                await self._subscriptions.renew(session, self._timeout, engine_ids)

    async def _changed_within(self, delay: float | None) -> bool:
        """Wait until the profile has changed, or for a delay if there is one; tell which it was."""
        waiting = {asyncio.ensure_future(self._changed.wait())}
        if delay is not None:
            waiting.add(asyncio.ensure_future(self._pause(delay)))
        try:
            await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in waiting:
                task.cancel()
        changed = self._changed.is_set()
        self._changed.clear()
        return changed

    async def _pause(self, delay: float) -> Literal[True]:
        await self._reconnect.sleep(self._reconnect.spread(delay))
        return True
