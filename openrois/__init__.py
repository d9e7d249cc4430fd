"""The control plane of OpenRoIS: types, engine, sessions, gateway. It imports no media, game engine or robot code."""

from openrois.version import __version__

__all__ = ["__version__"]
