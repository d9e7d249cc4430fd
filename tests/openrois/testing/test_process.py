"""An adapter's program behind a gateway of its own: the errors where it does not do its part."""

import signal
import sys

import pytest

from openrois.testing import launched

pytestmark = pytest.mark.extra(name="gateway")

IGNORING = f"""
import signal
from openrois.adapter import Component, serve
import asyncio

class Arm(Component):
    pass

async def main():
    signal.signal({int(signal.SIGTERM)}, signal.SIG_IGN)
    async with serve(Arm(), engine_id="robot"):
        await asyncio.Event().wait()

asyncio.run(main())
"""


async def test_one_that_ends_by_itself() -> None:
    with pytest.raises(RuntimeError, match="exit status 3"):
        async with launched(sys.executable, "-c", "raise SystemExit(3)"):
            pass


async def test_one_that_never_connects() -> None:
    with pytest.raises(TimeoutError):
        async with launched(sys.executable, "-c", "import time; time.sleep(60)", patience=0.5):
            pass


async def test_one_that_does_not_stop() -> None:
    with pytest.raises(TimeoutError):
        async with launched(sys.executable, "-c", IGNORING, patience=3) as gateway:
            assert gateway.engine.directory.profile.engine_ids() == ("gateway", "robot")
