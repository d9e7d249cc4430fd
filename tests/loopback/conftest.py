from collections.abc import AsyncIterator, Iterator

import pytest

from tests.support import loopback
from tests.support.demo import Demo, running_demo
from tests.support.loopback import Engine, Viewer


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo that all loopback tests share. What went wrong in it unseen is in its log."""
    with running_demo(tmp_path_factory.mktemp("demo")) as running:
        yield running
        assert "Traceback" not in running.log(), running.log()


@pytest.fixture
async def engine() -> AsyncIterator[Engine]:
    async with loopback.engine() as engine:
        yield engine


@pytest.fixture
async def viewer(engine: Engine) -> AsyncIterator[Viewer]:
    async with loopback.viewer(engine) as viewer:
        yield viewer
