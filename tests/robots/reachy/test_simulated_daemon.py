"""The simulated daemon does as was measured on the vendor's."""

from collections.abc import AsyncIterator

import pytest

from tests.robots.reachy.daemon_suite import DaemonSuite
from tests.support.reachy import DaemonPlace, LocalDaemon

pytestmark = pytest.mark.extra(name="reachy")


class TestSimulatedDaemon(DaemonSuite):
    @pytest.fixture
    async def daemon(self) -> AsyncIterator[DaemonPlace]:
        async with LocalDaemon.running() as daemon:
            yield daemon
