"""One robot behind one gateway, and applications in front of it."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot


@pytest.fixture
async def robot() -> Robot:
    return Robot()


@pytest.fixture
async def gateway() -> AsyncIterator[Gateway]:
    async with deployment.gateway() as running:
        yield running


@pytest.fixture
async def adapter(gateway: Gateway, robot: Robot) -> AsyncIterator[Adapter]:
    async with deployment.adapter(gateway, *robot.parts(), extension=robot.streams) as attached:
        yield attached


@pytest.fixture
async def app(gateway: Gateway, adapter: Adapter) -> AsyncIterator[Application]:
    async with deployment.application(gateway) as connected:
        yield connected


@pytest.fixture
async def other(gateway: Gateway, adapter: Adapter) -> AsyncIterator[Application]:
    """A second application."""
    async with deployment.application(gateway) as connected:
        yield connected


@pytest.fixture
async def stack() -> AsyncIterator[AsyncExitStack]:
    """Whatever a test enters here is left when it ends."""
    async with AsyncExitStack() as entered:
        yield entered
