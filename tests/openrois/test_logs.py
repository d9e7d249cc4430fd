"""Which log lines are shown."""

import logging
from collections.abc import Iterator

import pytest

from openrois.logs import set_up_logging

OURS = ("openrois", "openrois_signaling", "openrois_streaming", "openrois_avatar")


@pytest.fixture(autouse=True)
def _levels() -> Iterator[None]:
    before = {name: logging.getLogger(name).level for name in OURS}
    yield
    for name, level in before.items():
        logging.getLogger(name).setLevel(level)


@pytest.mark.parametrize(("verbose", "level"), [(False, logging.INFO), (True, logging.DEBUG)])
def test_our_news_and_everybody_elses_warnings(verbose: bool, level: int) -> None:
    set_up_logging(verbose=verbose)
    assert {logging.getLogger(f"{name}.module").getEffectiveLevel() for name in OURS} == {level}
    assert not logging.getLogger("aiohttp.server").isEnabledFor(logging.INFO)
