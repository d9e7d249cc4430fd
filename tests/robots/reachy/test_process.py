"""The adapter of a Reachy Mini as a process, over the simulated daemon."""

from collections.abc import AsyncIterator

import pytest

from tests.robots.reachy.process_suite import ProcessSuite
from tests.support.reachy import DaemonPlace, LocalDaemon


class TestProcess(ProcessSuite):
    @pytest.fixture
    async def daemon(self) -> AsyncIterator[DaemonPlace]:
        async with LocalDaemon.running(has_media=True, sound_from=1.0) as daemon:
            yield daemon
