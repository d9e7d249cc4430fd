"""A gateway among those of its cluster: which engines they have together, and the way to the gateway of each."""

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import ExitStack, asynccontextmanager, suppress
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.cluster.dial_failed import DialFailed
from openrois.engine.engine import Engine
from openrois.engine.tree import TreeChange
from openrois.errors import EngineUnreachable, StoreUnreachable
from openrois.federation.assertion import Assertion
from openrois.federation.cluster_directory import ClusterDirectory, Offer
from openrois.federation.counts import Counts
from openrois.federation.foreign_work import ForeignWork
from openrois.federation.gateway_link import GatewayLink
from openrois.federation.lines import Lines
from openrois.federation.neighbours import Neighbours
from openrois.federation.other_way import OtherWay
from openrois.federation.shared_quotas import TELLING_INTERVAL, SharedQuotas
from openrois.ownership.directorate import Directorate
from openrois.resumption.store import ResumeStore
from openrois.scope.views import Views
from openrois.transport.stream import MessageStream

__all__ = ["Federation"]

_log = logging.getLogger(__name__)

TOUCH_INTERVAL: Final = 3600.0
"""Seconds between two signs to the store that the sessions of this gateway live: it forgets others after a day."""

_NOT_LISTED: Final = "it has not told yet what it offers"


class Federation:
    """This gateway's part in its cluster.

    Args:
        link: to the other gateways.
        directorate: which gateway owns which engine.
        engine: this gateway's own: it has the adapters that are connected here.
        lines: the sessions here that can be resumed.
        resume_store: has the tokens of all gateways.
        other_way: of STOP, where the link fails.
        quotas: what subjects have at all gateways.
        sleep: waits for some seconds.

    Attributes:
        works: what each application here has at other gateways.
        gateway_id: of this gateway.
        directory: the engines of all gateways.
        views: what applications of each scope see of them.
        counts: of requests to other gateways, and of sessions that were resumed.
        quotas: what subjects have at all gateways.
    """

    def __init__(
        self,
        link: GatewayLink,
        directorate: Directorate,
        engine: Engine,
        lines: Lines,
        resume_store: ResumeStore,
        other_way: OtherWay,
        quotas: SharedQuotas,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self.works: set[ForeignWork] = set()
        self.lines = lines
        self.resume_store = resume_store
        self.other_way = other_way
        self.counts = Counts()
        self.quotas = quotas
        self._sleep = sleep
        self._kept: dict[str, object] = {}
        self.gateway_id = link.gateway_id
        self.directory = ClusterDirectory(engine.engine_id, self._claimed_by)
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
                tasks.start(self._touch_lines())
                tasks.start(self._tell_quotas())
                neighbours = Neighbours(self._link, self.directory, tasks, self.quotas)
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
            self.counts.calls["unreached"] += 1
            raise EngineUnreachable(str(error)) from None

    @property
    def relayed(self) -> int:
        """The number of commands of applications here that run at other gateways."""
        return sum(work.running for work in self.works)

    @property
    def others(self) -> tuple[str, ...]:
        """The other gateways that are there now."""
        return tuple(sorted(self._link.present.keys() - {self.gateway_id}))

    @property
    def is_joined(self) -> bool:
        """Whether other gateways can be reached now, as far as NATS goes."""
        return not self._link.trouble

    def keep_alive(self, line_id: str, owner: object) -> None:
        """Keep a line in the store until `forget_line` is called with the same owner."""
        self._kept[line_id] = owner

    def forget_line(self, line_id: str, owner: object) -> None:
        """Keep a line no longer, unless another session goes on with it here."""
        if self._kept.get(line_id) is owner:
            del self._kept[line_id]

    async def _touch_lines(self) -> None:
        while True:
            await self._sleep(TOUCH_INTERVAL)
            with suppress(StoreUnreachable):
                await self.resume_store.touch(tuple(self._kept))

    async def _tell_quotas(self) -> None:
        while True:
            self.quotas.tell_changes(len(self._link.present))
            await self._sleep(TELLING_INTERVAL)

    def require_reachable(self, engine_id: str) -> None:
        """Do nothing where no other gateway owns an engine that is not in the directory.

        Raises:
            EngineUnreachable: one does, and cannot be asked; the message says why.
        """
        owner = self._directorate.owners.get(engine_id)
        if owner is None or owner.gateway_id == self.gateway_id:
            return
        self.counts.calls["unreached"] += 1
        why = self._link.trouble or (_NOT_LISTED if owner.gateway_id in self._link.present else "it is not there")
        raise EngineUnreachable(f"{engine_id} belongs to gateway {owner.gateway_id}, which is not reached: {why}")

    def owner_of(self, engine_id: str) -> str | None:
        """Return the gateway that owns an engine, whether it is reached or not; None where none does."""
        owner = self._directorate.owners.get(engine_id)
        return self.directory.gateway_of(engine_id) if owner is None else owner.gateway_id

    def _claimed_by(self, engine_id: str) -> str | None:
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
