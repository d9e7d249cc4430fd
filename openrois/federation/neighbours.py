"""The other gateways of a cluster: the directory of each is followed for as long as it is there."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal, Role
from openrois.cluster.dial_failed import DialFailed
from openrois.cluster.presence import Present
from openrois.errors import RoISError
from openrois.federation.assertion import Assertion
from openrois.federation.cluster_directory import ClusterDirectory, Offer
from openrois.federation.gateway_link import GatewayLink
from openrois.federation.shared_quotas import SharedQuotas
from openrois.federation.version_skew import is_tried, told_version
from openrois.jsonrpc.session import RpcSession
from openrois.remote.directory_follower import DirectoryFollower, FollowedEngine
from openrois.remote.rpc_call import RpcCalls
from openrois.transport.backoff import Backoff
from openrois.transport.stream import StreamClosed
from openrois.version import __version__

__all__ = ["Neighbours"]

_log = logging.getLogger(__name__)

_IN_GOOD_ORDER: Final = frozenset({1000, 1001, 1012})
"""Close codes of a gateway that leaves in good order: what it offered is not failing, it comes back elsewhere."""


class Neighbours:
    """Follows the directories of all other gateways that are there.

    Args:
        link: to the other gateways.
        directory: gets what they offer.
        tasks: owns what follows each of them.
        quotas: tells each of them what subjects have here.
        sleep: waits for some seconds between two attempts.
        clock: monotonic seconds.
    """

    def __init__(
        self,
        link: GatewayLink,
        directory: ClusterDirectory,
        tasks: TaskScope,
        quotas: SharedQuotas,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._link = link
        self._directory = directory
        self._tasks = tasks
        self._quotas = quotas
        self._sleep = sleep
        self._followed: dict[str, asyncio.Task[None]] = {}
        me = Principal(f"gateway {link.gateway_id}", frozenset({Role.VIEWER}), ("*",))
        self._assertion = Assertion.of(me)

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Follow gateways that come, until they go, while the block runs."""
        stop = self._link.on_presence(self._handle_presence)
        try:
            self._handle_presence(self._link.present)
            yield
        finally:
            stop()

    def _handle_presence(self, present: Mapping[str, Present]) -> None:
        for gateway_id in present.keys() - self._followed.keys() - {self._link.gateway_id}:
            self._followed[gateway_id] = self._tasks.start(self._follow(gateway_id))
            theirs = present[gateway_id].version
            if theirs != __version__:
                level = logging.INFO if is_tried(theirs, __version__) else logging.WARNING
                _log.log(level, "%s", told_version(gateway_id, theirs, __version__))

    async def _follow(self, gateway_id: str) -> None:
        """Follow one gateway until it is there no more."""
        backoff = Backoff(first=0.05, factor=2, limit=1.0, lasting=5.0)
        clock = asyncio.get_running_loop().time
        try:
            while gateway_id in self._link.present:
                began = clock()
                closed = await self._follow_once(gateway_id)
                self._directory.remove_gateway(gateway_id, lost=closed.code not in _IN_GOOD_ORDER)
                await self._sleep(backoff.after(clock() - began))
        finally:
            del self._followed[gateway_id]
        # It may have come back since it was looked for.
        self._handle_presence(self._link.present)

    async def _follow_once(self, gateway_id: str) -> StreamClosed:
        try:
            stream = await self._link.dial(gateway_id, self._assertion.hello())
        except DialFailed as error:
            _log.info("%s", error)
            return StreamClosed(error.code, error.reason)
        session = RpcSession(stream, peer=f"gateway {gateway_id}")
        follower = DirectoryFollower(RpcCalls(session), partial(self._take, gateway_id))
        session.notifications = follower.notifications()
        following = self._tasks.start(self._keep_following(follower, session, gateway_id))
        try:
            with self._quotas.telling(session.notify):
                return await session.run()
        finally:
            following.cancel()

    async def _keep_following(self, follower: DirectoryFollower, session: RpcSession, gateway_id: str) -> None:
        try:
            await follower.run()
        except RoISError as error:
            _log.warning("the directory of gateway %s cannot be followed: %s", gateway_id, error)
            await session.close(1002, str(error))

    def _take(self, gateway_id: str, changed: Mapping[str, FollowedEngine | None]) -> None:
        offers = {
            root_id: None if engine is None else Offer(engine.directory, engine.streaming)
            for root_id, engine in changed.items()
        }
        self._directory.put(gateway_id, offers)
