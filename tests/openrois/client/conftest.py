"""A client on each kind of gateway."""

from collections.abc import AsyncIterator

import pytest

from openrois.client import Client
from tests.support import grounds
from tests.support.grounds import Clock, Ground, Line

NEEDS = {"gateway": pytest.mark.extra(name="gateway")}


@pytest.fixture(params=[pytest.param(name, marks=NEEDS.get(name, ())) for name in grounds.GROUNDS])
async def ground(request: pytest.FixtureRequest) -> AsyncIterator[Ground]:
    async with grounds.ground(request.param) as standing:
        yield standing


@pytest.fixture
async def client(ground: Ground) -> AsyncIterator[Client]:
    async with ground.client() as connected:
        yield connected


@pytest.fixture
async def line() -> AsyncIterator[Line]:
    async with grounds.line() as running:
        yield running


@pytest.fixture
def clock() -> Clock:
    return Clock()
