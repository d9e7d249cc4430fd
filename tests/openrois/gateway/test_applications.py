"""An application's share of signaling."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

from openrois_signaling.relay import PEERS_PER_OWNER

from openrois.contract import Client
from openrois.gateway.applications import MAX_ENDING, _Signaling
from tests.support.authorization import Watched, place


async def test_an_engine_that_offers_without_an_end() -> None:
    """One that did not answer either made a gateway keep 20 MB for each second that it did so."""
    robot = Watched("robot")
    robot.streams.may_answer.clear()
    async with place(robot) as here:
        signaling = _Signaling(here.host)
        client = Client("c", lambda _method, _params: None)
        signaling.app = cast(Any, SimpleNamespace(client_id="c", client=client))

        def offer(number: int) -> bool:
            told = {"peer_id": f"robot/{number}", "generation": 1, "sdp": "v=0", "streams": []}
            return signaling.passes("signaling.offer", told)

        passed = [offer(number) for number in range(PEERS_PER_OWNER + 3 * MAX_ENDING)]
        assert passed == [True] * PEERS_PER_OWNER + [False] * 3 * MAX_ENDING
        assert len(here.host.tasks) == MAX_ENDING
        robot.streams.may_answer.set()
        async with asyncio.timeout(30):
            await robot.streams.called.wait()
            for _ in range(10):
                await asyncio.sleep(0)
        assert not offer(1000)
        assert len(here.host.tasks) == 1
