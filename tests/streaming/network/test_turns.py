import asyncio
from collections.abc import Awaitable, Callable
from functools import partial

import pytest
from openrois_streaming.network.turns import DATAGRAMS_PER_TURN, DEFERRED_LIMIT, TIME_PER_TURN, Turns, TurnTaking

from tests.support.streaming import settle

BACKLOG = 1024


class Loop:
    """Peer connections with a backlog each, whose datagrams take `cost` seconds, and a watch over every turn."""

    def __init__(self, peers: int, cost: float) -> None:
        self.now = 0.0
        self.cost = cost
        self.turns = Turns(lambda: self.now)
        self.worked_off = [0] * peers
        self._tasks = [asyncio.ensure_future(self._work(each)) for each in range(peers)]
        self.largest, self.longest = 0, 0.0

    async def _work(self, peer: int) -> None:
        backlog: asyncio.Queue[bytes] = asyncio.Queue()
        for _ in range(BACKLOG):
            backlog.put_nowait(b"datagram")
        taking = TurnTaking(self.turns, backlog.get)
        while True:
            await taking.receive()
            self.worked_off[peer] += 1
            self.now += self.cost

    async def run(self, until: Callable[[], bool]) -> None:
        """Let the loop turn, and see how much each turn takes in."""
        while not until():
            before, began = list(self.worked_off), self.now
            await asyncio.sleep(0)
            self.largest = max(self.largest, *(now - then for now, then in zip(self.worked_off, before, strict=True)))
            self.longest = max(self.longest, self.now - began)

    async def close(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


async def test_a_turn_of_the_loop_takes_in_so_many_datagrams_of_a_peer() -> None:
    loop = Loop(peers=1, cost=0.0)
    await loop.run(lambda: loop.worked_off == [BACKLOG])
    assert loop.largest == DATAGRAMS_PER_TURN
    await loop.close()


@pytest.mark.parametrize("cost", [0.0001, 0.0005, 0.01])
async def test_a_turn_of_the_loop_takes_so_long_for_all_peers_and_none_is_forgotten(cost: float) -> None:
    loop = Loop(peers=5, cost=cost)
    await loop.run(lambda: sum(loop.worked_off) >= BACKLOG)
    assert loop.longest < TIME_PER_TURN + 1.5 * cost
    assert min(loop.worked_off) > BACKLOG / 5 / 2
    await loop.close()


async def test_waiting_time_of_a_reader_is_not_charged() -> None:
    now = 0.0
    turns = Turns(lambda: now)
    arrived: asyncio.Queue[bytes] = asyncio.Queue()
    taking = TurnTaking(turns, arrived.get)
    arrived.put_nowait(b"first")
    await taking.receive()
    now += 0.001
    waiting = asyncio.ensure_future(taking.receive())
    await settle()
    now += 5.0
    arrived.put_nowait(b"second")
    assert await waiting == b"second"
    assert not turns.is_spent


async def test_checks_wait_for_their_turn_in_order_and_in_bounded_numbers() -> None:
    now, done = 0.0, list[int]()
    turns = Turns(lambda: now)

    def verify(number: int) -> None:
        nonlocal now
        done.append(number)
        now += TIME_PER_TURN

    assert [turns.run_or_defer(partial(verify, each)) for each in range(DEFERRED_LIMIT + 3)].count(False) == 2
    assert done == [0], "one spends a turn"
    await asyncio.sleep(0)
    assert done == [0, 1]
    for _ in range(DEFERRED_LIMIT):
        await asyncio.sleep(0)
    assert done == list(range(DEFERRED_LIMIT + 1))


async def test_a_reader_that_is_cancelled_while_it_waits_for_a_turn_is_forgotten() -> None:
    turns = Turns(lambda: 0.0)
    waiting: Awaitable[None] = asyncio.ensure_future(turns.next())
    await asyncio.sleep(0)
    waiting.cancel()  # type: ignore[attr-defined]
    await settle()
    await turns.next()


async def test_a_datagram_is_not_lost_with_a_reader_that_gives_up_while_it_waits_for_a_turn() -> None:
    turns = Turns(lambda: 0.0)
    arrived: asyncio.Queue[bytes] = asyncio.Queue()
    taking = TurnTaking(turns, arrived.get)
    arrived.put_nowait(b"first")
    arrived.put_nowait(b"second")
    waiting = asyncio.ensure_future(taking.receive())
    turns.spend(TIME_PER_TURN)
    await asyncio.sleep(0)
    assert arrived.qsize() == 1, "it has the first one, and waits for a turn"
    # As DTLS does when it is time to repeat its last flight.
    waiting.cancel()
    await asyncio.wait({waiting})
    assert waiting.cancelled()
    async with asyncio.timeout(60):
        assert [await taking.receive(), await taking.receive()] == [b"first", b"second"]
