"""The built web page, as package data."""

from importlib.resources import files
from importlib.resources.abc import Traversable

__all__ = ["static_files"]


def static_files() -> Traversable:
    """Return the folder that holds the built page; it has no `index.html` until `make page` ran."""
    return files(__name__) / "static"
