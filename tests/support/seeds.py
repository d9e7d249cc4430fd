"""The seeds of the fault suite: all twenty where one costs little, else a few, and twenty where that is asked for."""

import os
from typing import Any, Final

import pytest

__all__ = ["ALL", "SOME", "lasting"]

ALL: Final = range(20)
SOME: Final = range(int(os.environ.get("OPENROIS_SEEDS", "2")))


def lasting(*short: int) -> list[Any]:
    """Return the seeds of `SOME` for a fault that takes seconds: all but the `short` ones are marked as long."""
    return [pytest.param(seed, marks=() if seed in short else pytest.mark.long) for seed in SOME]
