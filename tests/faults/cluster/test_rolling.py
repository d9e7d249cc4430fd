"""F49: gateways are stopped in good order and started again, one after the other."""

import asyncio
import signal
from pathlib import Path

import pytest

from tests.support.cluster_site import cluster_site
from tests.support.histories import Completed
from tests.support.postgres import Server
from tests.support.seeds import lasting

pytestmark = [pytest.mark.usefixtures("haproxy", "nats"), pytest.mark.timeout(300)]


@pytest.mark.parametrize("seed", lasting())
async def test_f49_a_rolling_restart_loses_no_command(seed: int, postgres_server: Server, tmp_path: Path) -> None:
    async with cluster_site(seed, postgres_server, tmp_path) as here:
        await here.crowd()
        for gateway in here.chance.sample(list(here.cluster.gateways.values()), 3):
            await here.turns(0.5)
            gateway.signal(signal.SIGTERM)
            assert await gateway.ended() == 0
            await here.all_move()
            await gateway.start()
            await gateway.ready()
            await here.all_move()
            assert await asyncio.gather(*(here.cluster.owner_id(each) for each in here.adapters))
    ends = {entry.status for entry in here.history.entries if isinstance(entry, Completed)}
    assert ends == {"OK"}
