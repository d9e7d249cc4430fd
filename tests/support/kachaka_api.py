"""The vendor's Kachaka API, which is not there for every Python."""

from importlib.util import find_spec
from typing import Final

import pytest

__all__ = ["IS_THERE", "needs_kachaka"]

IS_THERE: Final = find_spec("kachaka_api") is not None

needs_kachaka: Final = pytest.mark.skipif(
    not IS_THERE, reason="the Kachaka API is there for Python 3.12 and older: all tests of the Kachaka are left out"
)
"""Skips a test without it; the folder with the others is left out (`tests/conftest.py`)."""
