"""How many messages of one connection are taken in a row."""

import asyncio
import json

from openrois.jsonrpc.read_budget import FAIR_SHARE, FAIR_TEXT, FAIR_TIME, fair_share
from openrois.jsonrpc.session import RpcSession
from openrois.transport.memory import memory_pair


def test_fewer_in_a_row_where_a_turn_takes_long() -> None:
    share = fair_share()
    assert 1 <= share < FAIR_SHARE
    for _ in range(10):
        share = fair_share(share, FAIR_TIME)
    assert share == FAIR_SHARE
    assert fair_share(share, 2 * FAIR_TIME) == FAIR_SHARE // 4
    for _ in range(10):
        share = fair_share(share, 2 * FAIR_TIME)
    assert share == 1


async def test_what_is_long_leaves_others_their_turn() -> None:
    """Other tasks have their turn behind so many characters at the latest, however many messages wait."""
    taken = 0

    def take(_params: object) -> None:
        nonlocal taken
        taken += 1

    near, far = memory_pair(capacity=4096)
    for padding in (["x" * 4000] * 1000, [""] * 1000):
        session = RpcSession(near, notifications={"take": take})
        for text in padding:
            await far.send(json.dumps({"jsonrpc": "2.0", "method": "take", "params": {"x": text}}))
        running, most, before = asyncio.ensure_future(session.run()), 0, taken
        while taken < before + 1000:
            last = taken
            await asyncio.sleep(0)
            most = max(most, taken - last)
        assert 1 <= most <= (FAIR_TEXT // 4000 + 1 if padding[0] else FAIR_SHARE)
        running.cancel()
        await asyncio.wait({running})
