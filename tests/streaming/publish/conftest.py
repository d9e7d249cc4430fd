"""A rendition with a source, a clock and encoders in the hand of the test."""

import pytest

from tests.support.rendition_stage import Stage


@pytest.fixture
def stage() -> Stage:
    return Stage()
