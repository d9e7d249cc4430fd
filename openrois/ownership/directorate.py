"""The ownership of engines as one gateway uses it: claim, renew, release, watch, over any store."""

import asyncio
import random
import time
from collections import Counter
from collections.abc import Awaitable, Callable, Iterable, Mapping
from contextlib import (
    AbstractAsyncContextManager,
    AbstractContextManager,
    AsyncExitStack,
    suppress,
)
from dataclasses import replace
from types import MappingProxyType, TracebackType
from typing import Final, Self

from openrois.aio.tasks import TaskScope
from openrois.errors import BadParameter, StoreUnreachable
from openrois.ownership.access import StoreAccess
from openrois.ownership.claims import Claim, Owner
from openrois.ownership.errors import ClaimRefused, GatewayReplaced
from openrois.ownership.owners import OwnerChanges, Owners
from openrois.ownership.rules import BLOCK, TTL, Reading, Record, Waiting, judge_claim
from openrois.ownership.store import Digest, OwnershipStore, Renewed

__all__ = ["PATIENCE", "Directorate"]

PATIENCE: Final = 1.0
"""Seconds in which every call has its result or its error."""

_ENTERING: Final = 5.0
"""Seconds for a step while a gateway starts: nothing waits for it yet, and the machine may be busy with starting."""

_ATTEMPTS: Final = 8
"""Times that a claim is judged anew because another gateway was faster."""

_MOST_HINTS: Final = 1024
"""Engines that are read again one by one; of more, all are read."""


class Directorate(AbstractAsyncContextManager["Directorate"]):
    """The engines that a gateway owns, and the owners of all others.

    Enter it as long as the gateway runs. Within the block one renewal prolongs all claims, three times in a time-out;
    leaving the block releases them.

    A claim belongs to the gateway that has the connection of the adapter:

        async with Directorate(store, "gateway-a") as directorate:
            claim = await directorate.claim("kachaka", instance, above=greatest_epoch_of_adapter)

    Where the store cannot be reached, claims that hold go on: what is owned is served, and an adapter that dials its
    owner again is taken back. A new claim fails within a second, and `problem` says why.

    Args:
        store: where ownership is kept.
        gateway_id: of this gateway; no other process may have it.
        ttl: seconds for which claims hold after a renewal.
        patience: seconds in which a call has its result or its error.
        clock: monotonic seconds.
        sleep: waits for some seconds.
        chance: a number from 0 up to 1.

    Attributes:
        gateway_id: of this gateway.
        claims: the claims of this gateway by engine; a claim leaves when another gateway has the engine.
        owners: the owner of each engine that has one, for routing. The gateway of an owner may be dead.
        access: the way to the store.
        outcomes: number of claims that were granted, refused or failed; those that held already are not counted.

    Raises:
        StoreUnreachable: on entering: the store is not there.
    """

    def __init__(
        self,
        store: OwnershipStore,
        gateway_id: str,
        *,
        ttl: float = TTL,
        patience: float = PATIENCE,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        chance: Callable[[], float] = random.random,
    ) -> None:
        self.gateway_id = gateway_id
        self._store = store
        self._ttl = ttl
        self._clock = clock
        self._sleep = sleep
        self._chance = chance
        self._ttl_ms = round(ttl * 1000)
        self._run = 0
        self._renewed = 0.0
        self._expires_ms = 0
        self.access = StoreAccess(store.name, ttl, patience, clock)
        self.outcomes: Counter[str] = Counter({"granted": 0, "refused": 0, "failed": 0})
        self._claims: dict[str, Claim] = {}
        self._claiming: Counter[str] = Counter()
        self._owners = Owners()
        self._is_stale = True
        self._doubtful: set[str] = set()
        self._hinted: set[str] = set()
        self._has_hints = asyncio.Event()
        self._settling = asyncio.Lock()
        self._reading = asyncio.Lock()
        self._stack = AsyncExitStack()
        self.claims: Mapping[str, Claim] = MappingProxyType(self._claims)
        self.owners: Mapping[str, Owner] = self._owners.by_engine

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            started = self._clock()
            registered = await self.access.ask(self._store.register(self.gateway_id, self._ttl_ms), _ENTERING)
            self._run = registered.run
            self._note_renewed(started, registered)
            stack.callback(self._owners.close)
            stack.push_async_callback(self._leave)
            stack.callback(self._store.listen(self._note_hint))
            await self._read_owners(_ENTERING)
            tasks = await stack.enter_async_context(TaskScope())
            tasks.start(self._keep_renewing())
            tasks.start(self._follow_hints())
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    # What a gateway does.

    async def claim(self, engine_id: str, instance: str, *, above: int = 0) -> Claim:
        """Claim an engine, because its adapter has connected to this gateway.

        An adapter that dials its owner again gets the claim that holds, without the store; it is a new claim where
        `above` shows that the block is used up, or that another gateway owned the engine meanwhile.

        Args:
            engine_id: the engine.
            instance: the random text that the adapter process sends; for an adapter that sends none, a text that the
                gateway makes for each connection.
            above: the greatest epoch that the adapter says it has ever seen; 0 for none.

        Raises:
            ClaimRefused: another adapter process has brought this engine, and its claim holds.
            StoreUnreachable: the store did not answer in time.
            GatewayReplaced: another process runs as this gateway.
            BadParameter: `above` leaves no epochs.
        """
        held = self._claims.get(engine_id)
        if held is not None and held.instance == instance and above < held.last_epoch and self.holds(engine_id):
            return replace(held, until=self._renewed + self._ttl)
        self._claiming[engine_id] += 1
        try:
            async with self.access.bounded():
                claim = await self._claim(engine_id, instance, above)
            self.outcomes["granted"] += 1
            return claim
        except ClaimRefused:
            self.outcomes["refused"] += 1
            raise
        except (StoreUnreachable, GatewayReplaced, BadParameter):
            self.outcomes["failed"] += 1
            raise
        finally:
            self._claiming[engine_id] -= 1
            if not self._claiming[engine_id]:
                del self._claiming[engine_id]

    async def release(self, engine_id: str) -> None:
        """Release an engine: its adapter is gone for good, or is handed over. Nothing happens where it is not owned.

        Raises:
            StoreUnreachable: the store did not answer in time; the next renewal releases the engine.
        """
        claim = self._claims.pop(engine_id, None)
        if claim is None:
            return
        async with self.access.bounded():
            await self._release(Record(engine_id, self.gateway_id, claim.instance, claim.first_epoch))

    async def renew(self) -> None:
        """Prolong all claims, and read what has changed meanwhile. Within the block that happens by itself.

        Raises:
            StoreUnreachable: the store did not answer in time.
            GatewayReplaced: another process runs as this gateway.
        """
        async with self._settling:
            async with self.access.bounded(is_urgent=True):
                digest = await self._renew()
                if digest != self._owners.digest:
                    self._is_stale = True
                if self._is_stale:
                    await self._read_owners()
            for engine_id in [each for each in self._doubtful if not self._claiming[each]]:
                async with self.access.bounded():
                    await self._settle_doubt(engine_id)

    @property
    def problem(self) -> str:
        """Why nothing can be claimed now; empty where it can."""
        return self.access.problem

    @property
    def run(self) -> int:
        """The number of the process that runs as this gateway: of two processes the later has the greater one."""
        return self._run

    @property
    def hold_left(self) -> float:
        """Seconds for which the claims of this gateway hold without another renewal."""
        return max(0.0, self._renewed + self._ttl - self._clock())

    def holds(self, engine_id: str) -> bool:
        """Tell whether a claim of this gateway holds, by its own clock: it was renewed less than a time-out ago."""
        return engine_id in self._claims and self._clock() < self._renewed + self._ttl

    def watch(self) -> AbstractContextManager[OwnerChanges]:
        """Return a block with the changes of owners, which begin with all owners of now.

        The owner of an engine is None where it has none. Of each engine the last change alone waits for the reader:

            with directorate.watch() as changes:
                async for engine_id, owner in changes:
                    ...
        """
        return self._owners.watch()

    # Claiming.

    async def _claim(self, engine_id: str, instance: str, above: int) -> Claim:
        for _ in range(_ATTEMPTS):
            if self._clock() >= self._renewed + self._ttl / 2:
                await self._renew()
            reading = await self._read(engine_id)
            if reading.run != self._run:
                await self._renew()
                continue
            ruling = judge_claim(reading, instance, above, self.access.contact)
            if isinstance(ruling, Waiting):
                raise ClaimRefused(engine_id, ruling.gateway_id, ruling.seconds)
            record = Record(engine_id, self.gateway_id, instance, ruling.first_epoch)
            if await self._write(record, reading.record, ruling.expired_ms):
                latest = self._owners.by_engine.get(engine_id)
                if latest is not None and latest.epoch > record.first_epoch:
                    # The adapter has gone on to another gateway before this one was told that its claim was written.
                    raise ClaimRefused(engine_id, latest.gateway_id, self._ttl)
                return self._note_claim(record)
        raise StoreUnreachable(f"{engine_id} has changed hands {_ATTEMPTS} times while it was claimed: dial again")

    async def _read(self, engine_id: str) -> Reading:
        reading = await self.access.ask(self._store.read(engine_id, self.gateway_id))
        self.access.note_answer(reading.now_ms, has_lost_renewal=reading.own_expires_ms < self._expires_ms)
        return reading

    async def _write(self, record: Record, seen: Record | None, expired_ms: int | None) -> bool:
        """Write a claim, and tell whether that was done; where that is not known, it is read."""
        try:
            return await self.access.ask(self._store.write(record, self._run, seen, expired_ms))
        except StoreUnreachable:
            # It may be written yet: then the next renewal finds a claim that this gateway does not have.
            if (await self._read(record.engine_id)).record != record:
                raise
            return True

    async def _release(self, record: Record) -> None:
        self._owners.note(record.engine_id, None)
        self._doubtful.add(record.engine_id)
        await self.access.ask(self._store.release(record, self._run))
        self._doubtful.discard(record.engine_id)

    def _note_claim(self, record: Record) -> Claim:
        first, until = record.first_epoch, self._renewed + self._ttl
        claim = Claim(record.engine_id, self.gateway_id, record.instance, first, first + BLOCK - 1, until)
        self._claims[claim.engine_id] = claim
        self._doubtful.discard(claim.engine_id)
        self._owners.note(claim.engine_id, Owner(claim.engine_id, self.gateway_id, claim.instance, first))
        return claim

    # Renewing.

    async def _keep_renewing(self) -> None:
        delay = self._ttl / 3
        while True:
            await self._sleep(delay)
            try:
                await self.renew()
                delay = self._ttl / 3
            except (StoreUnreachable, GatewayReplaced):
                # `problem` says so, and it was logged.
                delay = self._ttl / 10 * (0.5 + self._chance() / 2)

    async def _renew(self) -> Digest:
        started = self._clock()
        renewed = await self.access.ask(self._store.renew(self.gateway_id, self._run, self._ttl_ms))
        if renewed is None:
            raise self._note_replaced()
        self._note_renewed(started, renewed)
        return renewed.digest

    def _note_renewed(self, started: float, renewed: Renewed) -> None:
        # Counted from before the question: the store's own count begins later, and so does not end sooner.
        self._renewed = started
        self.access.note_answer(renewed.now_ms, has_lost_renewal=renewed.former_expires_ms < self._expires_ms)
        self._expires_ms = renewed.now_ms + self._ttl_ms

    def _note_replaced(self) -> GatewayReplaced:
        error = GatewayReplaced(self.gateway_id)
        for engine_id in tuple(self._claims):
            self._lose(engine_id, None)
        self.access.note_replaced(error)
        return error

    async def _settle_doubt(self, engine_id: str) -> None:
        """Make store and gateway agree on an engine that one of them says this gateway owns, and the other does not."""
        claim = self._claims.get(engine_id)
        record = (await self._read(engine_id)).record
        is_ours = record is not None and record.gateway_id == self.gateway_id
        if claim is None:
            # A claim whose fate was not known when it failed, or a release likewise.
            if record is not None and is_ours:
                await self._release(record)
        elif record is None or record.first_epoch < claim.first_epoch:
            # The store has lost its last commits: this claim is later than all that it knows.
            ours = Record(engine_id, self.gateway_id, claim.instance, claim.first_epoch)
            if not await self._write(ours, record, None):
                return
        elif is_ours and record.instance == claim.instance:
            self._note_claim(record)
        else:
            # It is later; or the same epochs were granted again by a store that had lost this claim.
            self._lose(engine_id, None if is_ours else record.owner)
            return
        self._doubtful.discard(engine_id)

    # Reading.

    def _note_hint(self, engine_ids: Iterable[str] | None) -> None:
        self._hinted.update(engine_ids or ())
        if engine_ids is None or len(self._hinted) > _MOST_HINTS:
            self._is_stale = True
        self._has_hints.set()

    async def _follow_hints(self) -> None:
        while True:
            await self._has_hints.wait()
            self._has_hints.clear()
            with suppress(StoreUnreachable):
                await self._read_owners()

    async def _read_owners(self, seconds: float | None = None) -> None:
        """Read the owners of the engines that were hinted at, or of all; `seconds` are as for `StoreAccess.ask`."""
        async with self._reading:
            engine_ids = None if self._is_stale else tuple(self._hinted)
            # What is hinted at from here on may come too late for this answer.
            self._hinted.clear()
            self._is_stale = False
            try:
                owners = await self.access.ask(self._store.owners(engine_ids), seconds)
            except BaseException:
                self._is_stale = True
                raise
            found = {each.engine_id: each for each in owners}
            for engine_id in engine_ids if engine_ids is not None else found.keys() | self._owners.by_engine.keys():
                self._compare(engine_id, found.get(engine_id))

    def _compare(self, engine_id: str, owner: Owner | None) -> None:
        """Compare what the store says of an engine with what this gateway knows."""
        claim = self._claims.get(engine_id)
        is_ours = owner is not None and owner.gateway_id == self.gateway_id
        if claim is not None and (owner is None or owner.epoch < claim.first_epoch):
            # Read before the claim was written; or the store has lost it.
            self._doubtful.add(engine_id)
        elif claim is not None and not is_ours:
            self._lose(engine_id, owner)
        elif is_ours and (claim is None or owner != self._owners.by_engine.get(engine_id)):
            # Being claimed just now; or a claim that failed and was written nevertheless.
            self._doubtful.add(engine_id)
        else:
            self._owners.note(engine_id, owner)

    def _lose(self, engine_id: str, owner: Owner | None) -> None:
        del self._claims[engine_id]
        self._doubtful.discard(engine_id)
        self._owners.note(engine_id, owner)

    async def _leave(self) -> None:
        with suppress(StoreUnreachable):
            async with self.access.bounded():
                await self.access.ask(self._store.leave(self.gateway_id, self._run))
