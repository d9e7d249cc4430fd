"""What moves is stopped, over real sockets, whatever fails."""

import random

import pytest
from openrois_bench.faults.deadman import FAULTS, fault


@pytest.mark.parametrize("name", FAULTS)
async def test_it_stops(name: str) -> None:
    assert await fault(name, random.Random(1)) >= 0
