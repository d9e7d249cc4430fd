"""Ownership as gateways see it, over every store: in the memory of one process, and in PostgreSQL."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest

from openrois.errors import BadParameter
from openrois.ownership.claims import Owner
from openrois.ownership.errors import ClaimRefused, GatewayReplaced
from openrois.ownership.rules import BLOCK, MAX_EPOCH, Reading, Record
from openrois.ownership.store import Renewed
from tests.support.ownership import NOW_MS, PATIENT, World, blocks_overlap, in_memory, in_postgres, until_owned


@pytest.fixture(
    params=[
        pytest.param("memory", marks=pytest.mark.extra(name="base")),
        pytest.param("postgres", marks=pytest.mark.extra(name="cluster")),
    ]
)
async def world(request: pytest.FixtureRequest) -> AsyncIterator[World]:
    if request.param == "memory":
        async with in_memory() as made:
            yield made
    else:
        async with in_postgres(request.getfixturevalue("postgres_server")) as made:
            yield made


class TestClaiming:
    async def test_an_engine_without_an_owner_is_claimed_at_once(self, world: World) -> None:
        gateway = await world.gateway("a")
        claim = await gateway.claim("kachaka", "one")
        assert (claim.engine_id, claim.gateway_id, claim.instance) == ("kachaka", "a", "one")
        assert (claim.first_epoch, claim.last_epoch) == (NOW_MS, NOW_MS + BLOCK - 1)
        assert claim.until == world.clocks["a"].now + 10
        assert gateway.holds("kachaka")
        assert gateway.claims == {"kachaka": claim}

    async def test_an_adapter_that_dials_its_owner_again_has_its_claim(self, world: World) -> None:
        gateway = await world.gateway("a")
        claim = await gateway.claim("kachaka", "one")
        await world.advance(3, gateway)
        again = await gateway.claim("kachaka", "one", above=claim.first_epoch + 7)
        assert (again.first_epoch, again.until) == (claim.first_epoch, claim.until + 3)

    @pytest.mark.parametrize("further", [0, 5_000_000])
    async def test_a_block_that_is_used_up_or_passed_is_followed_by_another(self, world: World, further: int) -> None:
        gateway = await world.gateway("a")
        claim = await gateway.claim("kachaka", "one")
        above = claim.last_epoch + further
        after = await gateway.claim("kachaka", "one", above=above)
        assert after.first_epoch > above
        assert gateway.claims["kachaka"] == after

    async def test_the_same_adapter_at_another_gateway_is_claimed_at_once(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        former = await a.claim("kachaka", "one")
        claim = await b.claim("kachaka", "one")
        assert claim.first_epoch > former.last_epoch
        assert await until_owned(a, "kachaka", "b")
        assert not a.holds("kachaka")
        assert a.claims == {}

    async def test_an_owner_that_lost_an_engine_claims_it_at_the_store(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        at_b = await b.claim("kachaka", "one")
        await until_owned(a, "kachaka", "b")
        assert (await a.claim("kachaka", "one")).first_epoch > at_b.last_epoch

    @pytest.mark.parametrize("where", ["a", "b"])
    async def test_another_adapter_waits_and_hears_for_whom_and_how_long(self, world: World, where: str) -> None:
        gateways = {name: await world.gateway(name) for name in ("a", "b")}
        claim = await gateways["a"].claim("kachaka", "one")
        await world.advance(2)
        with pytest.raises(ClaimRefused) as refused:
            await gateways[where].claim("kachaka", "two")
        assert (refused.value.engine_id, refused.value.gateway_id) == ("kachaka", "a")
        assert refused.value.wait == 8
        assert str(refused.value).startswith(
            "kachaka is owned by gateway a, where another adapter process brought it: "
        )
        assert "dial again in 8.0 s" in str(refused.value)
        assert gateways["a"].claims == {"kachaka": claim}

    async def test_another_adapter_need_not_wait_when_the_owner_has_released(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        former = await a.claim("kachaka", "one")
        await a.release("kachaka")
        assert not a.holds("kachaka")
        assert (await b.claim("kachaka", "two")).first_epoch > former.last_epoch

    async def test_a_release_of_what_is_not_owned_changes_nothing(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        await b.claim("kachaka", "one")
        await a.release("kachaka")
        await a.release("unknown")
        assert await until_owned(a, "kachaka", "b")
        assert b.holds("kachaka")

    async def test_of_adapters_that_come_at_once_one_has_the_engine(self, world: World) -> None:
        gateways = [await world.gateway(name) for name in "abc"]
        tries = (each.claim("kachaka", f"adapter of {each.gateway_id}") for each in gateways)
        found = await asyncio.gather(*tries, return_exceptions=True)
        assert sorted(type(each).__name__ for each in found) == ["Claim", "ClaimRefused", "ClaimRefused"]

    async def test_claims_at_once_have_blocks_of_their_own(self, world: World) -> None:
        gateways = [await world.gateway(name) for name in "abc"]
        tries = [each.claim("kachaka", "one", above=above) for each in gateways for above in (0, NOW_MS + 5 * BLOCK)]
        found = await asyncio.gather(*tries, return_exceptions=True)
        claims = [each for each in found if not isinstance(each, BaseException)]
        assert all(isinstance(each, ClaimRefused) for each in found if isinstance(each, BaseException))
        assert claims
        assert not blocks_overlap({(each.first_epoch, each.last_epoch) for each in claims})
        latest = max(claims, key=lambda each: each.first_epoch)
        for each in gateways:
            await each.renew()
            assert each.owners["kachaka"].epoch == latest.first_epoch
            assert each.holds("kachaka") == (each.gateway_id == latest.gateway_id)

    async def test_epochs_stay_numbers_that_every_language_reads(self, world: World) -> None:
        gateway = await world.gateway("a")
        with pytest.raises(BadParameter, match="no epochs left behind 9007199254740991"):
            await gateway.claim("kachaka", "one", above=MAX_EPOCH)
        assert gateway.claims == gateway.owners == {}


class TestTimeOut:
    async def test_an_owner_that_does_not_renew_loses_what_another_adapter_brings(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        former = await a.claim("kachaka", "one")
        await world.advance(10, b)
        assert not a.holds("kachaka")
        claim = await b.claim("kachaka", "two")
        assert claim.first_epoch > former.last_epoch
        await a.renew()
        assert a.claims == {}
        assert a.owners["kachaka"].gateway_id == "b"

    async def test_an_owner_that_renews_keeps_it(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        await world.advance(20, a, b)
        with pytest.raises(ClaimRefused) as refused:
            await b.claim("kachaka", "two")
        assert refused.value.wait == 10

    async def test_one_renewal_is_of_all_claims(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        claims = [await a.claim(f"robot-{number}", "one") for number in range(20)]
        await world.advance(9.5, b)
        await a.renew()
        await world.advance(9.5, b)
        for claim in claims:
            assert a.holds(claim.engine_id)
            with pytest.raises(ClaimRefused):
                await b.claim(claim.engine_id, "two")

    async def test_an_owner_that_comes_back_late_keeps_what_was_not_claimed_meanwhile(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        claim, _ = await a.claim("kachaka", "one"), await a.claim("reachy", "one")
        await world.advance(30, b)
        await b.claim("reachy", "two")
        await a.renew()
        assert a.holds("kachaka")
        assert a.claims.keys() == {"kachaka"}
        assert a.claims["kachaka"].first_epoch == claim.first_epoch
        with pytest.raises(ClaimRefused):
            await b.claim("kachaka", "two")

    async def test_a_claim_that_has_expired_is_a_new_one_for_its_own_adapter(self, world: World) -> None:
        gateway = await world.gateway("a")
        former = await gateway.claim("kachaka", "one")
        await world.advance(10)
        assert (await gateway.claim("kachaka", "one")).first_epoch > former.last_epoch

    async def test_the_time_out_is_the_owners_own(self, world: World) -> None:
        a, b = await world.gateway("a", ttl=30), await world.gateway("b", ttl=5)
        await a.claim("kachaka", "one")
        await world.advance(29, b)
        with pytest.raises(ClaimRefused) as refused:
            await b.claim("kachaka", "two")
        assert refused.value.wait == 1

    async def test_a_gateway_that_has_just_begun_lets_no_claim_time_out(self, world: World) -> None:
        a = await world.gateway("a")
        await a.claim("kachaka", "one")
        await world.advance(30)
        b = await world.gateway("b")
        await world.advance(4, b)
        with pytest.raises(ClaimRefused) as refused:
            await b.claim("kachaka", "two")
        assert refused.value.wait == 6
        await world.advance(6, b)
        assert await b.claim("kachaka", "two")

    async def test_nor_does_one_that_was_out_of_contact(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        await world.advance(30)
        with pytest.raises(ClaimRefused) as refused:
            await b.claim("kachaka", "two")
        assert refused.value.wait == 10
        await a.renew()
        assert a.holds("kachaka")

    async def test_the_clocks_of_gateways_do_not_matter(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        world.clocks["a"].now += 3600
        await a.renew()
        claim = await a.claim("kachaka", "one")
        assert claim.first_epoch == NOW_MS
        world.clocks["b"].now -= 3600
        with pytest.raises(ClaimRefused):
            await b.claim("kachaka", "two")

    async def test_a_store_whose_clock_is_stepped_on_takes_nothing_from_its_owner(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        await world.advance(12, a, b)
        await world.step_clock(3600)
        with pytest.raises(ClaimRefused):
            await b.claim("kachaka", "two")
        await world.advance(10, a, b)
        with pytest.raises(ClaimRefused):
            await b.claim("kachaka", "two")

    async def test_a_store_whose_clock_is_stepped_back_lets_dead_owners_time_out(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        former = await a.claim("kachaka", "one")
        await world.step_clock(-3600)
        await world.advance(12, b)
        claim = await b.claim("kachaka", "two")
        assert claim.first_epoch == former.first_epoch + BLOCK


class TestEnds:
    async def test_a_gateway_that_leaves_releases_its_engines(self, world: World) -> None:
        b = await world.gateway("b")
        a = await world.gateway("a")
        await a.claim("kachaka", "one")
        assert await until_owned(b, "kachaka", "a")
        await a.__aexit__(None, None, None)
        await until_owned(b, "kachaka", "")
        assert await b.claim("kachaka", "two")

    async def test_a_gateway_that_comes_back_has_released_what_it_owned(self, world: World) -> None:
        former, b = await world.gateway("a"), await world.gateway("b")
        await former.claim("kachaka", "one")
        await world.gateway("a")
        assert await b.claim("kachaka", "two")

    async def test_a_process_that_another_has_replaced_owns_nothing(self, world: World) -> None:
        former = await world.gateway("a")
        await former.claim("kachaka", "one")
        present = await world.gateway("a")
        claim = await present.claim("kachaka", "two")
        with pytest.raises(GatewayReplaced, match="another process has started as gateway a: give each"):
            await former.renew()
        assert former.claims == {}
        assert "another process" in former.problem
        with pytest.raises(GatewayReplaced):
            await former.claim("reachy", "one")
        await former.__aexit__(None, None, None)
        await present.renew()
        assert present.claims == {"kachaka": claim}


class TestLostCommits:
    async def test_an_owner_that_the_store_has_lost_stays_owner(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        await world.stored.keep_copy()
        claim = await b.claim("kachaka", "one")
        only_here = await b.claim("reachy", "three")
        await world.stored.lose_commits()
        await a.renew()
        await b.renew()
        await a.renew()
        assert b.claims == {"kachaka": claim, "reachy": only_here}
        assert a.claims == {}
        assert {each.gateway_id for each in a.owners.values()} == {"b"}

    async def test_a_block_that_the_store_has_lost_is_written_again(self, world: World) -> None:
        a = await world.gateway("a")
        former = await a.claim("kachaka", "one")
        await world.stored.keep_copy()
        claim = await a.claim("kachaka", "one", above=former.last_epoch)
        await world.stored.lose_commits()
        await a.renew()
        await a.renew()
        b = await world.gateway("b")
        assert b.owners["kachaka"].epoch == claim.first_epoch
        assert (await b.claim("kachaka", "one")).first_epoch > claim.last_epoch

    async def test_a_gateway_that_the_store_has_lost_goes_on(self, world: World) -> None:
        a = await world.gateway("a")
        await world.stored.keep_copy()
        b = await world.gateway("b")
        claim = await b.claim("kachaka", "one")
        await world.stored.lose_commits()
        later = await b.claim("reachy", "two")
        await b.renew()
        assert b.claims == {"kachaka": claim, "reachy": later}
        with pytest.raises(ClaimRefused):
            await a.claim("kachaka", "two")

    async def test_a_gateway_whose_renewal_the_store_has_lost_lets_no_claim_time_out(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        await a.claim("kachaka", "one")
        await world.stored.keep_copy()
        await world.advance(15, a, b)
        await world.stored.lose_commits()
        with pytest.raises(ClaimRefused) as refused:
            await b.claim("kachaka", "two")
        assert refused.value.wait == 10
        await a.renew()
        assert a.holds("kachaka")

    @pytest.mark.parametrize("used", [0, 400_000, BLOCK - 1])
    async def test_no_block_overlaps_one_that_the_adapter_has_seen(self, world: World, used: int) -> None:
        a, b, c = [await world.gateway(each) for each in "abc"]
        blocks = [await a.claim("kachaka", "one")]
        await world.stored.keep_copy()
        blocks.append(await b.claim("kachaka", "one"))
        await world.stored.lose_commits()
        blocks.append(await c.claim("kachaka", "one", above=blocks[-1].first_epoch + used))
        await b.renew()
        assert b.claims == {}
        assert not blocks_overlap((each.first_epoch, each.last_epoch) for each in blocks)


class TestWatching:
    async def test_a_watcher_begins_with_all_owners(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        claim = await a.claim("kachaka", "one")
        await until_owned(b, "kachaka", "a")
        with b.watch() as changes:
            engine_id, owner = await anext(changes)
        assert owner is not None
        assert (engine_id, owner.gateway_id, owner.instance, owner.epoch) == ("kachaka", "a", "one", claim.first_epoch)

    async def test_a_watcher_sees_how_it_ended(self, world: World) -> None:
        a, b = await world.gateway("a"), await world.gateway("b")
        seen: dict[str, Owner | None] = {}
        with b.watch() as changes:
            for number in range(10):
                await a.claim("kachaka", "one", above=NOW_MS + 3 * BLOCK * number)
                await a.claim(f"robot-{number}", "one")
                await a.release(f"robot-{number}")
            await a.claim("lamp", "one")
            async with asyncio.timeout(PATIENT):
                while {name: owner for name, owner in seen.items() if owner is not None} != a.owners:
                    engine_id, owner = await anext(changes)
                    seen[engine_id] = owner
        assert a.owners.keys() == {"kachaka", "lamp"}
        assert b.owners == a.owners

    async def test_a_watcher_ends_with_its_gateway(self, world: World) -> None:
        gateway = await world.gateway("a")
        await gateway.claim("kachaka", "one")
        with gateway.watch() as changes:
            await gateway.__aexit__(None, None, None)
            async with asyncio.timeout(PATIENT):
                assert [engine_id async for engine_id, _ in changes] == ["kachaka"]


class TestStore:
    """What the directorate relies on in every store."""

    async def test_a_claim_is_written_where_nothing_has_changed_since_it_was_read(self, world: World) -> None:
        store = await world.stored.connect("a")
        runs = {name: (await store.register(name, 10_000)).run for name in "ab"}
        first, second = Record("kachaka", "a", "one", 7), Record("kachaka", "b", "two", 8)
        assert not await store.write(first, runs["a"], second, None)
        assert await store.write(first, runs["a"], None, None)
        for stale in (None, replace(first, first_epoch=6), replace(first, gateway_id="b")):
            assert not await store.write(second, runs["b"], stale, None)
        assert (await store.read("kachaka", "b")).record == first
        assert await store.write(second, runs["b"], first, None)
        assert (await store.read("kachaka", "a")).record == second

    async def test_a_time_out_is_void_where_the_owner_has_renewed(self, world: World) -> None:
        store = await world.stored.connect("a")
        runs = {name: (await store.register(name, 10_000)).run for name in "ab"}
        first, second = Record("kachaka", "a", "one", 7), Record("kachaka", "b", "two", 8)
        await store.write(first, runs["a"], None, None)
        read = await store.read("kachaka", "b")
        assert read == Reading(first, NOW_MS + 10_000, 10_000, runs["b"], NOW_MS + 10_000, NOW_MS)
        await world.step_clock(1)
        renewed = await store.renew("a", runs["a"], 10_000)
        assert renewed == Renewed(runs["a"], NOW_MS + 10_000, NOW_MS + 1000, {"a": (1, 7)})
        assert not await store.write(second, runs["b"], first, read.expires_ms)
        assert await store.write(second, runs["b"], first, read.expires_ms + 1000)

    async def test_a_process_that_was_replaced_writes_and_releases_nothing(self, world: World) -> None:
        store = await world.stored.connect("a")
        former = (await store.register("a", 10_000)).run
        present = (await store.register("a", 10_000)).run
        assert present > former
        record = Record("kachaka", "a", "one", 7)
        assert not await store.write(record, former, None, None)
        assert await store.write(record, present, None, None)
        await store.release(record, former)
        await store.leave("a", former)
        assert await store.renew("a", former, 10_000) is None
        assert await store.owners(None) == await store.owners(["kachaka", "unknown"]) == [record.owner]
        assert await store.owners(["unknown"]) == []

    async def test_only_the_claim_that_is_meant_is_released(self, world: World) -> None:
        store = await world.stored.connect("a")
        run = (await store.register("a", 10_000)).run
        record = Record("kachaka", "a", "one", 7)
        await store.write(record, run, None, None)
        await store.release(replace(record, first_epoch=6), run)
        assert await store.owners(None) == [record.owner]
        await store.release(record, run)
        assert await store.owners(None) == []
        released = (await store.read("kachaka", "a")).record
        assert released is not None
        assert (released.owner, released.first_epoch) == (None, 7)
