"""The seeds of the fault suite: all twenty where one costs little, else a few, and twenty where that is asked for."""

import os
from typing import Final

__all__ = ["ALL", "SOME"]

ALL: Final = range(20)
SOME: Final = range(int(os.environ.get("OPENROIS_SEEDS", "2")))
