"""A component whose condition and commands are set by the test."""

import pytest

from tests.support.thing import Thing


@pytest.fixture
async def thing() -> Thing:
    return Thing()
