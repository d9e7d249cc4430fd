"""A gateway among those of its cluster: which engines they have together, and the way to the gateway of each."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import ExitStack, asynccontextmanager
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.cluster.dial_failed import DialFailed
from openrois.engine.engine import Engine
from openrois.engine.tree import TreeChange
from openrois.errors import EngineUnreachable
from openrois.federation.assertion import Assertion
from openrois.federation.cluster_directory import ClusterDirectory, Offer
from openrois.federation.gateway_link import GatewayLink
from openrois.federation.neighbours import Neighbours
from openrois.ownership.directorate import Directorate
from openrois.scope.views import Views
from openrois.transport.stream import MessageStream

__all__ = ["Federation"]

_log = logging.getLogger(__name__)

_NOT_LISTED: Final = "and has not told yet what it offers"


class Federation:
    """This gateway's part in its cluster.

    Args:
        link: to the other gateways.
        directorate: which gateway owns which engine.
        engine: this gateway's own: it has the adapters that are connected here.

    Attributes:
        gateway_id: of this gateway.
        directory: the engines of all gateways.
        views: what applications of each scope see of them.
    """

    def __init__(self, link: GatewayLink, directorate: Directorate, engine: Engine) -> None:
        self.gateway_id = link.gateway_id
        self.directory = ClusterDirectory(engine.engine_id, self._owner_of)
        self.views = Views(self.directory)
        self._link = link
        self._directorate = directorate
        self._engine = engine

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Keep the directory up to date while the block runs."""
        async with TaskScope() as tasks:
            with ExitStack() as stack:
                stack.callback(self._engine.changes.add(self._offer_own))
                tasks.start(self._follow_owners())
                neighbours = Neighbours(self._link, self.directory, tasks)
                stack.enter_context(neighbours.watching())
                yield

    async def dial(self, gateway_id: str, assertion: Assertion) -> MessageStream:
        """Return a stream to another gateway for a session of an application.

        Raises:
            EngineUnreachable: the gateway is not reached, or refuses.
        """
        try:
            return await self._link.dial(gateway_id, assertion.hello())
        except DialFailed as error:
            raise EngineUnreachable(str(error)) from None

    def require_reachable(self, engine_id: str) -> None:
        """Do nothing where no other gateway owns an engine that is not in the directory.

        Raises:
            EngineUnreachable: one does, and cannot be asked; the message says why.
        """
        owner = self._directorate.owners.get(engine_id)
        if owner is None or owner.gateway_id == self.gateway_id:
            return
        why = self._link.trouble or (_NOT_LISTED if owner.gateway_id in self._link.present else "which is not there")
        raise EngineUnreachable(f"{engine_id} belongs to gateway {owner.gateway_id}, which is not reached: {why}")

    def _owner_of(self, engine_id: str) -> str | None:
        owner = self._directorate.owners.get(engine_id)
        return None if owner is None else owner.gateway_id

    def _offer_own(self, change: TreeChange) -> None:
        """Offer what an adapter of this gateway does."""
        offered = change.former if change.latter is None else change.latter
        if offered is None:
            return
        root_id, latter = offered.profile.identifier.code, change.latter
        if root_id == self._engine.engine_id:
            return
        offer = None
        if latter is not None:
            ids = latter.profile.engine_ids()
            streaming = frozenset(each for each in ids if self._engine.extension_at(each) is not None)
            offer = Offer(latter, streaming)
        self.directory.put(self.gateway_id, {root_id: offer})
        former = change.former
        if former is not None and latter is not None and former.profile.identifier.code != root_id:
            self.directory.put(self.gateway_id, {former.profile.identifier.code: None})

    async def _follow_owners(self) -> None:
        with self._directorate.watch() as changes:
            async for engine_id, _owner in changes:
                self.directory.settle(engine_id)
                await asyncio.sleep(0)
