"""Location of Chromium on this machine."""

import shutil
from typing import Final

__all__ = ["find_chromium"]

_NAMES: Final = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def find_chromium() -> str | None:
    """Return the path of a Chromium or Chrome; None if none is installed."""
    return next((path for name in _NAMES if (path := shutil.which(name))), None)
