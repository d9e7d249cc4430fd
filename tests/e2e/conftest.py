from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser

from tests.support.browser import Visit, running_browser, visiting
from tests.support.conversation import meet
from tests.support.demo import Demo, Demos, hand_back
from tests.support.devices import Devices
from tests.support.people import Sitter

_HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort tests by the game engine of their demo, so that each demo starts once."""
    items.sort(key=_engine)


def _engine(item: pytest.Item) -> str:
    if not isinstance(item, pytest.Function) or _HERE not in item.path.parents:
        return ""
    if "avatar" in item.fixturenames:
        return str(getattr(item.module, "ENGINE", ""))
    return "synthetic" if "demo" in item.fixturenames else ""


@pytest.fixture(scope="session")
def devices_of_all(tmp_path_factory: pytest.TempPathFactory) -> Devices:
    return Devices(tmp_path_factory.mktemp("devices"))


@pytest.fixture(scope="module")
def devices(devices_of_all: Devices) -> Devices:
    """The browser's devices for the tests of one module: a person left of the middle of the picture, and beeps."""
    devices_of_all.see(lambda _: [Sitter("collins", x=0.4)], 0.5)
    devices_of_all.hear_beeps()
    return devices_of_all


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def browser(chromium: Path, devices_of_all: Devices) -> AsyncIterator[Browser]:
    """The browser of all tests. Tests that open a camera or microphone in it need `devices`, too."""
    async with running_browser(chromium, *devices_of_all.arguments) as browser:
        yield browser


@pytest.fixture(scope="session")
def demos(chromium: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demos]:
    with Demos(tmp_path_factory) as demos:
        yield demos


@pytest.fixture(scope="module")
def demo(demos: Demos) -> Iterator[Demo]:
    """A demo with colour bars and a marker tone. Its log is checked afterwards."""
    with demos.watched("synthetic") as demo:
        yield demo


@pytest.fixture(scope="module")
def avatar(request: pytest.FixtureRequest, demos: Demos) -> Iterator[Demo]:
    """A demo with an avatar, for a module that names its game engine in `ENGINE`."""
    engine: str = request.module.ENGINE
    request.getfixturevalue(engine)
    with demos.watched(engine) as demo:
        yield demo


@pytest_asyncio.fixture(loop_scope="session", autouse=True)
async def handed_back(request: pytest.FixtureRequest) -> AsyncIterator[None]:
    """What a test has stopped in a shared demo, on whichever page, is not stopped for the programs of the next one."""
    demos = request.getfixturevalue("demos") if "demos" in request.fixturenames else None
    yield
    if demos is not None and demos.running is not None:
        await hand_back(demos.running)


@pytest_asyncio.fixture(loop_scope="session")
async def guest(browser: Browser, avatar: Demo) -> AsyncIterator[Visit]:
    """The avatar's page, opened, with the avatar ready to be operated."""
    async with visiting(browser, avatar.page) as visit:
        await meet(visit)
        yield visit


@pytest_asyncio.fixture(loop_scope="session")
async def visit(browser: Browser, demo: Demo) -> AsyncIterator[Visit]:
    """The demo's page, opened."""
    async with visiting(browser, demo.page) as visit:
        yield visit
