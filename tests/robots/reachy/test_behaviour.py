"""A Reachy Mini behind a gateway, over its simulated daemon."""

from collections.abc import AsyncIterator

import pytest

from tests.robots.reachy.behaviour_suite import BehaviourSuite
from tests.support.reachy import DaemonPlace, LocalDaemon


class TestBehaviour(BehaviourSuite):
    gestures = ("greet",)

    @pytest.fixture
    async def daemon(self) -> AsyncIterator[DaemonPlace]:
        async with LocalDaemon.running() as daemon:
            yield daemon
