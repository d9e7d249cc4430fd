"""Tests of tokens listen to everything that is logged, so that a token in it is found."""

import logging
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def _loud() -> Iterator[None]:
    loggers = [logging.getLogger(name) for name in ("openrois", "aiohttp", "asyncio")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.DEBUG)
    yield
    for logger, level in zip(loggers, before, strict=True):
        logger.setLevel(level)
