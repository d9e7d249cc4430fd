"""A gateway whose store is behind a bad network: each call has an end, and nothing is done twice."""

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import AsyncExitStack, suppress

import pytest

from openrois.errors import StoreUnreachable
from openrois.ownership.claims import Owner
from openrois.ownership.directorate import PATIENCE, Directorate
from openrois.ownership.errors import ClaimRefused
from openrois.ownership.memory_store import MemoryStore
from openrois.ownership.rules import Record
from openrois.ownership.store import Renewed
from tests.support.clock import Clock
from tests.support.jumping_loop import JumpingLoop
from tests.support.lossy_store import Fate, LossyStore
from tests.support.ownership import never

pytestmark = pytest.mark.extra(name="base")


class Network:
    """Two gateways, `a` and `b`, each with its own way to one store."""

    def __init__(self) -> None:
        self.wall = Clock(1_900_000_000.0)
        self.store = MemoryStore(self.wall)
        self.clock = Clock(1000.0)
        self.a = LossyStore(self.store)
        self.b = LossyStore(self.store)

    def advance(self, seconds: float) -> None:
        self.wall.now += seconds
        self.clock.now += seconds

    def gateway(self, name: str) -> Directorate:
        way = {"a": self.a, "b": self.b}[name]
        return Directorate(way, name, patience=60.0, clock=self.clock, sleep=never)


@pytest.fixture
def network() -> Network:
    return Network()


@pytest.fixture
async def a(network: Network) -> AsyncIterator[Directorate]:
    async with network.gateway("a") as made:
        yield made


@pytest.fixture
async def b(network: Network) -> AsyncIterator[Directorate]:
    async with network.gateway("b") as made:
        yield made


async def test_a_process_has_a_number_and_a_contact_without_breaks(network: Network, a: Directorate) -> None:
    assert a.run == network.store.gateways["a"].run
    network.advance(3.0)
    await a.renew()
    assert a.access.contact == 3.0
    network.a.fates = [Fate.LOST]
    with pytest.raises(StoreUnreachable):
        await a.renew()
    assert a.access.contact == 0.0
    assert a.access.failures == 1 < a.access.steps
    async with network.gateway("a") as later:
        assert later.run > a.run


class TestUnknownWrites:
    async def test_a_claim_whose_answer_is_lost_is_read_again(self, network: Network, a: Directorate) -> None:
        network.a.fates = [Fate.ARRIVES, Fate.ANSWER_LOST]
        claim = await a.claim("kachaka", "one")
        assert claim.first_epoch == network.store.records["kachaka"].first_epoch
        assert network.a.calls[-3:] == ["read", "write", "read"]
        assert a.problem == ""

    async def test_a_claim_that_was_not_written_fails_and_is_not_repeated(
        self, network: Network, a: Directorate
    ) -> None:
        network.a.fates = [Fate.ARRIVES, Fate.LOST]
        with pytest.raises(StoreUnreachable, match="the connection was lost"):
            await a.claim("kachaka", "one")
        assert network.a.calls[-3:] == ["read", "write", "read"]
        assert network.store.records == a.claims == {}
        assert a.outcomes == {"granted": 0, "refused": 0, "failed": 1}

    @pytest.mark.parametrize("fate", [Fate.ANSWER_LOST, Fate.LATE])
    async def test_a_claim_that_was_written_after_all_is_released_by_the_next_renewal(
        self, network: Network, a: Directorate, b: Directorate, fate: Fate
    ) -> None:
        network.a.fates = [Fate.ARRIVES, fate, Fate.LOST]
        with pytest.raises(StoreUnreachable):
            await a.claim("kachaka", "one")
        await network.a.arrive()
        with pytest.raises(ClaimRefused):
            await b.claim("kachaka", "two")
        assert b.outcomes == {"granted": 0, "refused": 1, "failed": 0}
        await a.renew()
        assert await b.claim("kachaka", "two")

    async def test_a_claim_that_comes_late_takes_nothing_from_a_later_one(
        self, network: Network, a: Directorate, b: Directorate
    ) -> None:
        network.a.fates = [Fate.ARRIVES, Fate.LATE]
        with pytest.raises(StoreUnreachable):
            await a.claim("kachaka", "one")
        claim = await b.claim("kachaka", "one")
        await network.a.arrive()
        for each in (a, b, a):
            await each.renew()
        assert b.claims == {"kachaka": claim}
        assert a.owners["kachaka"].epoch == claim.first_epoch

    async def test_a_claim_of_the_same_adapter_that_was_written_after_all_is_had(
        self, network: Network, a: Directorate
    ) -> None:
        claim = await a.claim("kachaka", "one")
        network.a.fates = [Fate.ARRIVES, Fate.LATE, Fate.LOST]
        with pytest.raises(StoreUnreachable):
            await a.claim("kachaka", "one", above=claim.last_epoch)
        await network.a.arrive()
        await a.renew()
        assert a.claims["kachaka"].first_epoch == network.store.records["kachaka"].first_epoch > claim.last_epoch

    @pytest.mark.parametrize("fate", [Fate.LOST, Fate.ANSWER_LOST])
    async def test_a_release_that_fails_is_made_by_the_next_renewal(
        self, network: Network, a: Directorate, b: Directorate, fate: Fate
    ) -> None:
        await a.claim("kachaka", "one")
        network.a.fates = [fate]
        with pytest.raises(StoreUnreachable):
            await a.release("kachaka")
        assert a.claims == {}
        await a.renew()
        assert await b.claim("kachaka", "two")

    async def test_a_store_that_always_changes_is_left_after_some_attempts(
        self, network: Network, a: Directorate, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        async def fail(record: Record, run: int, seen: Record | None, expired_ms: int | None) -> bool:
            return False

        monkeypatch.setattr(network.store, "write", fail)
        with pytest.raises(StoreUnreachable, match="kachaka has changed hands 8 times"):
            await a.claim("kachaka", "one")


class TestStoreAway:
    async def test_an_owner_takes_its_adapter_back_until_its_time_is_over(
        self, network: Network, a: Directorate
    ) -> None:
        claim = await a.claim("kachaka", "one")
        network.a.is_cut = True
        with suppress(StoreUnreachable):
            await a.renew()
        network.clock.now += 9.9
        calls = len(network.a.calls)
        assert await a.claim("kachaka", "one") == claim
        assert len(network.a.calls) == calls
        network.clock.now += 0.1
        with pytest.raises(StoreUnreachable):
            await a.claim("kachaka", "one")
        assert a.claims == {"kachaka": claim}

    async def test_nothing_is_repeated_when_the_store_comes_back(self, network: Network, a: Directorate) -> None:
        network.a.is_cut = True
        for name in ("kachaka", "reachy"):
            with pytest.raises(StoreUnreachable):
                await a.claim(name, "one")
        network.a.is_cut = False
        await a.renew()
        assert network.store.records == {}

    async def test_a_gateway_that_missed_an_answer_lets_no_claim_time_out(
        self, network: Network, a: Directorate, b: Directorate
    ) -> None:
        await a.claim("kachaka", "one")
        for second in range(12):
            network.advance(1)
            network.b.fates = [Fate.LOST] if second == 5 else []
            with suppress(StoreUnreachable):
                await b.renew()
        with pytest.raises(ClaimRefused) as refused:
            await b.claim("kachaka", "two")
        # Its contact began with the answer after the one that it missed.
        assert refused.value.wait == 5

    async def test_why_it_is_away_is_said_once_and_that_it_is_back(
        self, network: Network, a: Directorate, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.INFO)
        network.a.is_cut = True
        for _ in range(3):
            with pytest.raises(StoreUnreachable):
                await a.renew()
        assert a.problem == "the store: the connection was lost (lost)"
        network.a.is_cut = False
        await a.renew()
        assert a.problem == ""
        assert [record.message for record in caplog.records] == [
            "the store: the connection was lost (lost); engines that are owned go on, and no other is claimed",
            "the store answers again",
        ]

    async def test_a_gateway_begins_with_one_that_is_slower_than_calls_may_be(self, network: Network) -> None:
        class Slow(LossyStore):
            async def register(self, gateway_id: str, ttl_ms: int) -> Renewed:
                for _ in range(5):
                    await asyncio.sleep(0)
                return await super().register(gateway_id, ttl_ms)

        async with Directorate(Slow(network.store), "a", patience=0.0, sleep=never) as a:
            assert a.run == network.store.gateways["a"].run

    async def test_a_gateway_does_not_begin_without_it(self, network: Network) -> None:
        network.a.is_cut = True
        with pytest.raises(StoreUnreachable):
            await network.gateway("a").__aenter__()


class TestHints:
    async def test_a_hint_that_is_lost_is_made_good_by_the_next_renewal(
        self, network: Network, a: Directorate, b: Directorate
    ) -> None:
        network.b.is_deaf = True
        await a.claim("kachaka", "one")
        await asyncio.sleep(0)
        assert b.owners == {}
        await b.renew()
        assert b.owners == a.owners

    async def test_a_hint_that_cannot_be_followed_is_made_good_too(
        self, network: Network, a: Directorate, b: Directorate
    ) -> None:
        network.b.is_cut = True
        await a.claim("kachaka", "one")
        for _ in range(5):
            await asyncio.sleep(0)
        network.b.is_cut = False
        await b.renew()
        assert b.owners == a.owners

    async def test_many_hints_are_one_reading_of_all(self, network: Network, a: Directorate, b: Directorate) -> None:
        read: list[object] = []
        owners = network.store.owners

        async def note(engine_ids: Iterable[str] | None) -> list[Owner]:
            read.append(engine_ids)
            return await owners(engine_ids)

        network.store.owners = note  # type: ignore[method-assign]
        claim = await a.claim("kachaka", "one")
        for number in range(2000):
            record = Record(f"robot-{number}", "a", "one", claim.first_epoch)
            await network.store.write(record, network.store.gateways["a"].run, None, None)
        with b.watch() as changes:
            async with asyncio.timeout(60):
                while len(b.owners) < 2001:
                    await anext(changes)
        assert len(read) <= 4
        assert None in read


class Hung(MemoryStore):
    """A store that does not answer from some call on."""

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__(clock)
        self.hung: set[str] = set()

    def __getattribute__(self, name: str) -> object:
        return _wait if name in super().__getattribute__("__dict__").get("hung", ()) else super().__getattribute__(name)


async def _wait(*_: object) -> None:
    await asyncio.Event().wait()


@pytest.mark.parametrize("hung", [{"read"}, {"write"}, {"renew"}, {"release"}, {"read", "write", "renew", "release"}])
def test_every_call_ends_within_a_second_where_the_store_hangs(hung: set[str]) -> None:
    async def use() -> None:
        said: list[str] = []
        clock = asyncio.get_running_loop().time
        store = Hung(lambda: 1_900_000_000 + clock())
        async with Directorate(store, "a", clock=clock) as gateway:
            await gateway.claim("kachaka", "one")
            store.hung = hung
            works: list[Callable[[], Awaitable[object]]] = [
                lambda: gateway.claim("kachaka", "one"),
                lambda: gateway.claim("reachy", "one"),
                gateway.renew,
                lambda: gateway.release("kachaka"),
            ]
            for work in works:
                began = clock()
                try:
                    await work()
                except StoreUnreachable as error:
                    said.append(str(error))
                assert clock() - began <= PATIENCE
            store.hung = set()
        assert set(said) == {"the memory of this gateway did not answer within 0.45 s"}

    with asyncio.Runner(loop_factory=JumpingLoop) as runner:
        runner.run(use())


def test_claims_are_renewed_by_themselves_and_sooner_after_a_failure() -> None:
    async def use() -> None:
        clock = asyncio.get_running_loop().time
        store = MemoryStore(lambda: 1_900_000_000 + clock())
        way = LossyStore(store)
        renewed = []

        async def renew(gateway_id: str, run: int, ttl_ms: int) -> Renewed | None:
            renewed.append(round(clock(), 2))
            return await LossyStore.renew(way, gateway_id, run, ttl_ms)

        way.renew = renew  # type: ignore[method-assign]
        async with Directorate(way, "a", ttl=9.0, clock=clock, chance=lambda: 0.5) as gateway:
            await gateway.claim("kachaka", "one")
            await asyncio.sleep(7)
            way.is_cut = True
            await asyncio.sleep(3)
            way.is_cut = False
            await asyncio.sleep(20)
            assert gateway.holds("kachaka")
        assert renewed[:5] == [3, 6, 9, 9.68, 10.35]
        assert renewed[5:8] == [13.35, 16.35, 19.35]

    with asyncio.Runner(loop_factory=JumpingLoop) as runner:
        runner.run(use())


async def test_leaving_ends_where_the_store_is_away(network: Network) -> None:
    async with AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(network.gateway("a"))
        await gateway.claim("kachaka", "one")
        network.a.is_cut = True
    assert network.store.records["kachaka"].gateway_id == "a"
