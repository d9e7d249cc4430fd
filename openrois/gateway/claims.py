"""Claims of one gateway among several: it owns the engines of the adapters that are connected to it."""

import asyncio
import logging
import secrets
from collections.abc import Awaitable, Callable, Collection, Coroutine
from contextlib import AbstractAsyncContextManager, suppress
from hashlib import sha256
from types import TracebackType
from typing import Any, Final, Self

from openrois.aio.tasks import TaskScope
from openrois.contract import Directory
from openrois.engine.engine import Engine
from openrois.errors import BadParameter, RoISError, StoreUnreachable
from openrois.leases.epochs import ClaimedEpochs
from openrois.ownership.claims import Owner
from openrois.ownership.directorate import Directorate
from openrois.ownership.errors import ClaimRefused, GatewayReplaced
from openrois.ownership.rules import TTL
from openrois.remote.proxy import RemoteProxy

__all__ = ["AdapterClaims", "GatewayClaims", "NotOwned"]

_log = logging.getLogger(__name__)

KEPT: Final = TTL
"""Seconds for which a claim outlasts a lost connection, so that the same adapter is taken back without the store."""

RETRY: Final = 2.0
"""Seconds after which a claim is worth another attempt: an owner may release an engine long before a time-out."""


class NotOwned(RoISError):
    """This gateway cannot own an engine now; its adapter may dial again, this gateway or another one.

    Attributes:
        retry_after: seconds after which it is worth an attempt.
        is_refused: another adapter process brought the engine; else the store cannot be asked now.
    """

    def __init__(self, reason: str, retry_after: float, *, is_refused: bool) -> None:
        super().__init__(reason)
        self.retry_after = retry_after
        self.is_refused = is_refused


class GatewayClaims(AbstractAsyncContextManager["GatewayClaims"]):
    """The engines that a gateway owns by the connections of their adapters.

    Enter it after the directorate and before adapters are served.

    Args:
        engine: the gateway's main engine.
        directorate: of this gateway.
        epochs: the epochs of this gateway's leases.
        sleep: waits for some seconds.

    Attributes:
        on_claimed: called with engines that were claimed, before they are attached.
    """

    def __init__(
        self,
        engine: Engine,
        directorate: Directorate,
        epochs: ClaimedEpochs,
        *,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self.on_claimed: Callable[[Collection[str]], Awaitable[None]] = _nothing
        self._engine = engine
        self._directorate = directorate
        self._epochs = epochs
        self._sleep = sleep
        self._adapters: dict[str, AdapterClaims] = {}
        self._kept: dict[str, asyncio.Task[None]] = {}
        self._releasing: dict[str, asyncio.Task[None]] = {}
        self._tasks = TaskScope()

    async def __aenter__(self) -> Self:
        await self._tasks.__aenter__()
        self._epochs.on_low = lambda engine_id, last: self._start(self._claim_again(engine_id, last))
        self._tasks.start(self._follow())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._epochs.on_low = lambda _engine_id, _last: None
        await self._tasks.__aexit__(kind, error, trace)

    def adapter(self, proxy: RemoteProxy, evict: Callable[[str], None]) -> "AdapterClaims":
        """Return the claims for the connection of an adapter; there are none yet.

        Args:
            proxy: the adapter.
            evict: detaches the adapter at once and closes its connection, for the reason given.
        """
        return AdapterClaims(self, proxy, evict)

    def check(self, adapter: "AdapterClaims", directory: Directory) -> None:
        """Check what an adapter offers before it is claimed; an older connection of the same process is ended.

        Raises:
            BadParameter: its engines cannot be attached here.
        """
        for engine_id in directory.profile.engine_ids():
            former = self._adapters.get(engine_id)
            if former is not None and former is not adapter and former.instance == adapter.instance:
                former.evict("the same adapter has connected again", is_lost=True)
        self._engine.check(adapter.proxy, directory, own=False)

    def reserve(self, engine_id: str, adapter: "AdapterClaims") -> None:
        """Note which adapter brings an engine.

        Raises:
            BadParameter: another adapter is about to bring it.
        """
        if self._adapters.setdefault(engine_id, adapter) is not adapter:
            raise BadParameter(f"the engine id {engine_id!r} is taken already: each engine needs one of its own")

    async def claim(self, engine_id: str, adapter: "AdapterClaims") -> None:
        """Claim an engine for the adapter that has reserved it, and give its leases their epochs.

        Raises:
            BadParameter: no epochs are left.
            ClaimRefused: it is owned through another adapter process.
            StoreUnreachable: the store did not answer in time.
            GatewayReplaced: another process runs as this gateway.
        """
        if (keeping := self._kept.pop(engine_id, None)) is not None:
            keeping.cancel()
            held = self._directorate.claims.get(engine_id)
            if held is not None and held.instance != adapter.instance:
                # This gateway is the owner, and knows that the adapter process of before is not connected any more.
                self._release(engine_id)
        if (releasing := self._releasing.get(engine_id)) is not None:
            await asyncio.wait({releasing})
        claim = await self._directorate.claim(engine_id, adapter.instance, above=adapter.proxy.identity.epoch)
        self._epochs.grant(engine_id, claim.first_epoch, claim.last_epoch)

    def drop(self, engine_id: str, *, is_lost: bool) -> None:
        """End the claim that an adapter has on an engine: at once, or after a while where its connection was lost."""
        del self._adapters[engine_id]
        keeping = self._start(self._keep(engine_id)) if is_lost and engine_id in self._directorate.claims else None
        if keeping is None:
            self._release(engine_id)
        else:
            self._kept[engine_id] = keeping

    def _start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None] | None:
        try:
            return self._tasks.start(work)
        except RuntimeError:
            # The gateway ends: its directorate releases everything.
            return None

    async def _keep(self, engine_id: str) -> None:
        await self._sleep(KEPT)
        del self._kept[engine_id]
        self._release(engine_id)

    def _release(self, engine_id: str) -> None:
        self._epochs.withdraw(engine_id)
        if (releasing := self._start(self._release_now(engine_id))) is not None:
            self._releasing[engine_id] = releasing

    async def _release_now(self, engine_id: str) -> None:
        try:
            # Where the store does not answer, the next renewal releases it.
            with suppress(StoreUnreachable):
                await self._directorate.release(engine_id)
        finally:
            if self._releasing.get(engine_id) is asyncio.current_task():
                del self._releasing[engine_id]

    async def _claim_again(self, engine_id: str, last: int) -> None:
        """Claim another block of epochs for an engine whose own ends with `last`."""
        adapter = self._adapters.get(engine_id)
        while adapter is not None and self._adapters.get(engine_id) is adapter:
            try:
                above = max(last, adapter.proxy.identity.epoch)
                claim = await self._directorate.claim(engine_id, adapter.instance, above=above)
            except (StoreUnreachable, GatewayReplaced) as error:
                _log.warning("%s gets no further epochs yet: %s", engine_id, error)
                await self._sleep(RETRY)
            except (ClaimRefused, BadParameter) as error:
                _log.warning("%s gets no further epochs: %s", engine_id, error)
                return
            else:
                self._epochs.grant(engine_id, claim.first_epoch, claim.last_epoch)
                return

    async def _follow(self) -> None:
        with self._directorate.watch() as changes:
            async for engine_id, owner in changes:
                if engine_id not in self._directorate.claims:
                    self._lose(engine_id, owner)

    def _lose(self, engine_id: str, owner: Owner | None) -> None:
        """Give up an engine that this gateway does not own any more."""
        adapter = self._adapters.get(engine_id)
        if adapter is not None and engine_id in adapter.claimed:
            by = "this gateway has lost it" if owner is None else f"gateway {owner.gateway_id} owns it now"
            adapter.evict(f"{engine_id}: {by}", is_lost=False)
        elif (keeping := self._kept.pop(engine_id, None)) is not None:
            keeping.cancel()
            self._epochs.withdraw(engine_id)


class AdapterClaims:
    """The claims for one connection of an adapter.

    Attributes:
        proxy: the adapter.
        instance: tells its process from others; a digest of what it sends, or made here for one that sends nothing.
        claimed: the engines that are claimed for it.
    """

    def __init__(self, claims: GatewayClaims, proxy: RemoteProxy, evict: Callable[[str], None]) -> None:
        self.proxy = proxy
        self.instance = ""
        self.claimed: set[str] = set()
        self._reserved: set[str] = set()
        self._claims = claims
        self._evict = evict

    async def admit(self, directory: Directory) -> None:
        """Claim the engines that an adapter offers, but for those that are claimed for it already.

        Raises:
            BadParameter: its engines cannot be attached here.
            NotOwned: one of them cannot be claimed now.
        """
        # An adapter that answers the hello late has its name by then.
        self.instance = self.instance or _digest(self.proxy.identity.instance or secrets.token_hex(16))
        self._claims.check(self, directory)
        claimed = [engine_id for engine_id in directory.profile.engine_ids() if engine_id not in self.claimed]
        for engine_id in claimed:
            await self._claim(engine_id)
        if claimed:
            await self._claims.on_claimed(claimed)

    async def _claim(self, engine_id: str) -> None:
        self._claims.reserve(engine_id, self)
        self._reserved.add(engine_id)
        try:
            await self._claims.claim(engine_id, self)
        except ClaimRefused as refused:
            raise NotOwned(str(refused), min(refused.wait, RETRY), is_refused=True) from None
        except (StoreUnreachable, GatewayReplaced) as error:
            raise NotOwned(str(error), RETRY, is_refused=False) from None
        self.claimed.add(engine_id)

    def settle(self) -> None:
        """Release the engines that the adapter does not offer any more, once they are not in the tree."""
        for engine_id in self._reserved - set(self.proxy.engine_ids):
            self._reserved.discard(engine_id)
            self.claimed.discard(engine_id)
            self._claims.drop(engine_id, is_lost=False)

    def evict(self, reason: str, *, is_lost: bool) -> None:
        """End the connection, and the claims with it."""
        _log.warning("an adapter is sent away: %s", reason)
        self._evict(reason)
        self.end_claims(is_lost=is_lost)

    def end_claims(self, *, is_lost: bool) -> None:
        """End the claims; those of a lost connection last a while longer."""
        reserved, self._reserved, self.claimed = self._reserved, set(), set()
        for engine_id in reserved:
            self._claims.drop(engine_id, is_lost=is_lost)


async def _nothing(_engine_ids: Collection[str]) -> None:
    """Stand in where claims are of no further interest."""


def _digest(text: str) -> str:
    return sha256(text.encode(errors="surrogatepass")).hexdigest()[:32]
