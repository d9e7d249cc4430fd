"""The wire as JSON Schema and OpenRPC, in a folder for each version; `make generate` writes the newest."""

from importlib.resources import files
from typing import Final

__all__ = ["VERSION", "openrpc"]

VERSION: Final = "2026-11-21"
"""The newest version. A released one is never changed: a change of the wire gets a folder with a date of its own."""


def openrpc() -> bytes:
    """Return the OpenRPC document of the newest version, as JSON."""
    return (files(__name__) / VERSION / "openrpc.json").read_bytes()
