"""Lines and holdings as gateways see them, over every store: in the memory of one process, and in PostgreSQL."""

import asyncio
from collections.abc import AsyncIterator
from hashlib import sha256

import pytest

from openrois.resumption.lines import MAX_SPENT, Freed, Held, Holding, Redemption
from openrois.resumption.store import KEPT_FOR, MAX_PRUNED
from tests.support.resumption import Kept, kept_in_memory, kept_in_postgres

LAMP = Held("robot/lamp", "robot", "line", 7)


def digest(token: object) -> bytes:
    return sha256(str(token).encode()).digest()


@pytest.fixture(
    params=[
        pytest.param("memory", marks=pytest.mark.extra(name="base")),
        pytest.param("postgres", marks=pytest.mark.extra(name="cluster")),
    ]
)
async def kept(request: pytest.FixtureRequest) -> AsyncIterator[Kept]:
    if request.param == "memory":
        async with kept_in_memory() as made:
            yield made
    else:
        async with kept_in_postgres(request.getfixturevalue("postgres_server")) as made:
            yield made


class TestTokens:
    async def test_a_token_is_good_at_another_gateway_and_raises_the_generation(self, kept: Kept) -> None:
        assert await kept.store.issue("line", 0, "ann", digest("one"))
        assert await kept.other.redeem(digest("one"), "ann") == Redemption("line", 1)
        assert await kept.other.issue("line", 1, "ann", digest("two"))
        assert await kept.store.redeem(digest("two"), "ann") == Redemption("line", 2)

    async def test_an_unknown_token_or_that_of_another_subject_says_nothing(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        assert await kept.store.redeem(digest("other"), "ann") == Redemption()
        assert await kept.store.redeem(digest("one"), "bob") == Redemption()
        assert await kept.store.redeem(digest("one"), "ann") == Redemption("line", 1)

    async def test_a_token_of_a_line_is_used_up_by_the_next(self, kept: Kept) -> None:
        for token in ("one", "two"):
            assert await kept.store.issue("line", 0, "ann", digest(token))
        assert await kept.other.redeem(digest("one"), "ann") == Redemption("line", 0, is_replayed=True)

    async def test_a_token_that_comes_again_revokes_its_line_and_frees_what_it_holds(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.issue("another", 0, "ann", digest("another"))
        await kept.store.write([LAMP, Held("robot/voice", "robot", "another", 8)])
        await kept.store.redeem(digest("one"), "ann")
        await kept.store.issue("line", 1, "ann", digest("two"))
        assert await kept.other.redeem(digest("one"), "ann") == Redemption("line", 1, is_replayed=True)
        assert [each.component_ref for each in await kept.store.held(["robot"])] == ["robot/voice"]
        assert not await kept.store.issue("line", 1, "ann", digest("three"))
        assert await kept.store.redeem(digest("two"), "ann") == Redemption("line", 1, is_replayed=True)
        assert await kept.store.redeem(digest("three"), "ann") == Redemption()
        await kept.store.write([Held("robot/lamp", "robot", "line", 9)])
        assert [each.component_ref for each in await kept.store.held(["robot"])] == ["robot/voice"]

    async def test_of_gateways_that_redeem_one_token_at_once_one_has_it(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        stores = [kept.store, kept.other] * 8
        found = await asyncio.gather(*(each.redeem(digest("one"), "ann") for each in stores))
        assert sorted(found, key=lambda each: each.is_replayed) == [
            Redemption("line", 1),
            *[Redemption("line", 1, is_replayed=True)] * 15,
        ]

    async def test_a_session_that_was_resumed_elsewhere_issues_nothing_more(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.other.redeem(digest("one"), "ann")
        assert not await kept.store.issue("line", 0, "ann", digest("late"))
        assert await kept.other.issue("line", 1, "ann", digest("two"))
        assert await kept.store.redeem(digest("late"), "ann") == Redemption()

    async def test_a_redemption_that_the_store_has_lost_does_not_stop_its_session(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        assert await kept.store.issue("line", 2, "ann", digest("three"))
        assert await kept.store.redeem(digest("three"), "ann") == Redemption("line", 3)

    async def test_a_digest_that_is_issued_again_is_good_only_where_it_was_not_used(self, kept: Kept) -> None:
        for _ in range(2):
            assert await kept.store.issue("line", 0, "ann", digest("one"))
        assert not await kept.store.issue("another", 0, "ann", digest("one"))
        await kept.store.issue("line", 0, "ann", digest("two"))
        assert not await kept.store.issue("line", 0, "ann", digest("one"))
        assert await kept.store.redeem(digest("two"), "ann") == Redemption("line", 1)

    async def test_a_line_follows_its_session_to_another_subject(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.issue("line", 0, "b\0b \ud800", digest("two"))
        await kept.store.write([LAMP])
        (held,) = await kept.store.held(["robot"])
        assert held.subject.startswith("b")
        assert await kept.store.redeem(digest("two"), "ann") == Redemption()
        assert await kept.store.redeem(digest("two"), "b\0b \ud800") == Redemption("line", 1)

    async def test_a_line_has_the_rank_with_which_its_last_token_was_issued(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"), rank="person")
        await kept.store.write([LAMP])
        assert [each.rank for each in await kept.other.held(["robot"])] == ["person"]
        await kept.other.redeem(digest("one"), "ann")
        await kept.other.issue("line", 1, "ann", digest("two"), rank="script")
        assert [each.rank for each in await kept.store.held(["robot"])] == ["script"]

    async def test_used_tokens_of_a_line_are_kept_up_to_a_bound(self, kept: Kept) -> None:
        for number in range(MAX_SPENT + 3):
            await kept.store.issue("line", 0, "ann", digest(number))
        assert await kept.count() == (1, MAX_SPENT + 1, 0)
        assert await kept.store.redeem(digest(1), "ann") == Redemption()
        assert (await kept.store.redeem(digest(2), "ann")).is_replayed

    async def test_a_line_that_has_ended_is_unknown_and_holds_nothing(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.issue("line", 0, "ann", digest("two"))
        await kept.store.write([LAMP])
        for _ in range(2):
            await kept.other.end_line("line", 0)
        assert await kept.store.held(["robot"]) == ()
        assert await kept.store.redeem(digest("one"), "ann") == Redemption()
        assert await kept.store.redeem(digest("two"), "ann") == Redemption()
        await kept.store.issue("resumed", 0, "ann", digest("three"))
        await kept.store.redeem(digest("three"), "ann")
        await kept.store.end_line("resumed", 0)
        assert (await kept.count())[0] == 1, "it was resumed since"
        await kept.store.end_line("resumed", 1)
        assert (await kept.count())[:2] == (0, 0)


class TestHoldings:
    async def test_what_lines_hold_of_an_engine_is_seen_by_its_next_owner(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.write([])
        await kept.store.write([Held("robot/voice", "robot", "line", 8), LAMP, Held("other/lamp", "other", "line", 9)])
        lamp, voice = await kept.other.held(["robot", "unknown"])
        assert lamp == Holding("robot/lamp", "robot", "line", 7, "ann")
        assert (voice.component_ref, voice.epoch) == ("robot/voice", 8)
        assert len(await kept.other.held(["robot", "other"])) == 3
        assert await kept.other.held([]) == ()

    async def test_what_is_held_by_a_line_that_is_not_known_yet_counts_when_it_is(self, kept: Kept) -> None:
        await kept.store.write([LAMP])
        assert await kept.store.held(["robot"]) == ()
        await kept.store.issue("line", 0, "ann", digest("one"))
        assert [each.component_ref for each in await kept.store.held(["robot"])] == ["robot/lamp"]

    async def test_a_smaller_epoch_changes_nothing(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.issue("another", 0, "bob", digest("another"))
        await kept.store.write([LAMP])
        await kept.store.write([Held("robot/lamp", "robot", "another", 6), Held("x/y", "x", "line", 1)])
        await kept.store.write([Freed("robot/lamp", 6)])
        assert [each.line_id for each in await kept.store.held(["robot"])] == ["line"]
        await kept.store.write([Held("robot/lamp", "robot", "another", 7)])
        assert [each.line_id for each in await kept.store.held(["robot"])] == ["another"]

    async def test_what_was_freed_is_not_held_by_what_comes_late(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.write([LAMP])
        await kept.store.write([Freed("robot/lamp", 8)])
        assert await kept.store.held(["robot"]) == ()
        await kept.other.write([LAMP])
        assert await kept.store.held(["robot"]) == ()
        await kept.other.write([Held("robot/lamp", "robot", "line", 9)])
        assert len(await kept.store.held(["robot"])) == 1

    async def test_of_one_component_in_a_batch_the_last_change_counts(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        await kept.store.write([LAMP, Freed("robot/lamp", 7)])
        assert await kept.store.held(["robot"]) == ()
        await kept.store.write([Held("robot/lamp", "robot", "line", 8), Freed("robot/lamp", 7)])
        assert [each.epoch for each in await kept.store.held(["robot"])] == [8]

    async def test_batches_at_once_over_the_same_components_all_come_in(self, kept: Kept) -> None:
        await kept.store.issue("line", 0, "ann", digest("one"))
        names = [f"robot/{number}" for number in range(40)]

        async def write(number: int) -> None:
            held = [Held(name, "robot", "line", number) for name in names]
            await (kept.store, kept.other)[number % 2].write(held if number % 3 else reversed(held))

        await asyncio.gather(*map(write, range(12)), kept.other.redeem(digest("one"), "ann"))
        assert {each.epoch for each in await kept.store.held(["robot"])} == {11}


class TestAge:
    async def test_a_line_without_a_touch_is_removed_with_what_it_holds(self, kept: Kept) -> None:
        for line_id in ("old", "kept"):
            await kept.store.issue(line_id, 0, "ann", digest(line_id))
            await kept.store.write([Held(f"robot/{line_id}", "robot", line_id, 7)])
        await kept.advance(KEPT_FOR)
        await kept.store.touch(["kept", "unknown"])
        await kept.advance(1)
        await kept.store.issue("new", 0, "bob", digest("new"))
        assert await kept.store.redeem(digest("old"), "ann") == Redemption()
        assert [each.line_id for each in await kept.store.held(["robot"])] == ["kept"]
        await kept.store.write([Freed("robot/other", 1)])
        assert await kept.count() == (2, 2, 2)

    async def test_what_was_freed_long_ago_is_removed(self, kept: Kept) -> None:
        await kept.store.write([Freed("robot/lamp", 1)])
        await kept.advance(KEPT_FOR + 1)
        await kept.store.write([Freed("robot/voice", 1)])
        assert (await kept.count())[2] == 1

    async def test_so_many_are_removed_at_a_time(self, kept: Kept) -> None:
        for number in range(MAX_PRUNED + 5):
            await kept.store.issue(str(number), 0, "ann", digest(number))
        await kept.store.write(Freed(f"robot/{number}", 1) for number in range(MAX_PRUNED + 5))
        await kept.advance(KEPT_FOR + 1)
        for left in (5, 0):
            await kept.store.issue("new", 0, "bob", digest("new"))
            await kept.store.write([Freed("robot/new", 1)])
            assert await kept.count() == (left + 1, left + 1, left + 1)
