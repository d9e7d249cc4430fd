from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser

from tests.support.browser import Visit, running_browser, visiting
from tests.support.conversation import meet
from tests.support.demo import Demo, running_demo


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def browser(chromium: Path) -> AsyncIterator[Browser]:
    async with running_browser(chromium) as browser:
        yield browser


@pytest.fixture(scope="module")
def demo(chromium: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo with colour bars and a marker tone, for the tests of one module. What fails in it unseen is in its log."""
    with running_demo(tmp_path_factory.mktemp("demo")) as running:
        yield running
        assert "Traceback" not in running.log(), running.log()


@pytest.fixture(scope="module")
def avatar(request: pytest.FixtureRequest, chromium: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """A demo with an avatar, for the tests of one module, which names its game engine in `ENGINE`."""
    engine: str = request.module.ENGINE
    request.getfixturevalue(engine)
    with running_demo(tmp_path_factory.mktemp("avatar"), engine) as running:
        yield running
        assert "Traceback" not in running.log(), running.log()


@pytest_asyncio.fixture(loop_scope="session")
async def guest(browser: Browser, avatar: Demo) -> AsyncIterator[Visit]:
    """The avatar's page, opened and ready for whatever a person may want of it."""
    async with visiting(browser, avatar.page) as visit:
        await meet(visit)
        yield visit


@pytest_asyncio.fixture(loop_scope="session")
async def visit(browser: Browser, demo: Demo) -> AsyncIterator[Visit]:
    """The demo's page, opened."""
    async with visiting(browser, demo.page) as visit:
        yield visit
