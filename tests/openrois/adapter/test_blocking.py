"""An adapter that blocks its event loop gets a warning that says where."""

import asyncio
import logging
import threading
from collections.abc import Iterator

import pytest

from openrois.adapter import Component, command
from openrois.adapter.blocking import told_of_blocking
from openrois.testing import harness

pytestmark = pytest.mark.extra(name="base")


class Ears(logging.Handler):
    """Keeps log records, and wakes the test that waits for one."""

    def __init__(self) -> None:
        super().__init__()
        self.heard: list[str] = []
        self.news = threading.Event()

    def emit(self, record: logging.LogRecord) -> None:
        self.heard.append(record.getMessage())
        self.news.set()


@pytest.fixture
def ears() -> Iterator[Ears]:
    logger = logging.getLogger("openrois.adapter.blocking")
    logger.addHandler(ears := Ears())
    yield ears
    logger.removeHandler(ears)


async def test_it_says_where_and_says_it_once(ears: Ears) -> None:
    def drive_to_the_kitchen() -> None:
        assert ears.news.wait(5)
        # Long enough to be told again.
        assert not threading.Event().wait(0.05)

    with told_of_blocking(patience=0.01):
        drive_to_the_kitchen()
    (message,) = ears.heard
    assert "asyncio.to_thread" in message
    assert message.splitlines()[-1].strip()


async def test_another_block_is_logged_again(ears: Ears) -> None:
    with told_of_blocking(patience=0.01):
        for _ in range(2):
            ears.news.clear()
            assert ears.news.wait(5)
            await asyncio.sleep(0)
    # A machine that is busy may stand still once more, and is told of that too.
    assert len(ears.heard) >= 2


async def test_the_place_is_in_the_authors_code(ears: Ears) -> None:
    class Wheels(Component, authority="Test"):
        @command
        async def drive(self) -> None:
            # A machine that is busy may stand still before this, and is told of that first.
            while "in drive" not in "".join(ears.heard):
                ears.news.clear()
                assert ears.news.wait(5)

    async with harness(Wheels("wheels")) as client:
        with told_of_blocking(patience=0.01):
            await client.component("robot/wheels").command("drive")
    first, place, *_ = next(told for told in ears.heard if "in drive" in told).splitlines()
    assert "this call blocks the adapter" in first
    assert place.endswith("in drive")
    assert __file__ in place
