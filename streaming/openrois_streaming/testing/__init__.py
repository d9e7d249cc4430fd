"""Testing for those who write engines and viewers: bad networks, pictures and sounds that are known, and measurements.

    from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink

Nothing here needs a test runner; `plugin` is for pytest. `docs/testing.md` has examples. What is named here is imported
when it is asked for: pytest imports this package in every run of whoever has installed it.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from openrois_streaming.testing.delays import Delays
    from openrois_streaming.testing.link import Impairments, Link, LinkFigures
    from openrois_streaming.testing.lipsync import LipSyncFigures
    from openrois_streaming.testing.path import ImpairedPath
    from openrois_streaming.testing.pictures import PictureFigures, SeenPicture
    from openrois_streaming.testing.sink import MeasuringSink
    from openrois_streaming.testing.sounds import SoundFigures
    from openrois_streaming.testing.stage import playing

__all__ = [
    "Delays",
    "ImpairedPath",
    "Impairments",
    "Link",
    "LinkFigures",
    "LipSyncFigures",
    "MeasuringSink",
    "PictureFigures",
    "SeenPicture",
    "SoundFigures",
    "playing",
]

_PLACES = {
    "Delays": "delays",
    "ImpairedPath": "path",
    "Impairments": "link",
    "Link": "link",
    "LinkFigures": "link",
    "LipSyncFigures": "lipsync",
    "MeasuringSink": "sink",
    "PictureFigures": "pictures",
    "SeenPicture": "pictures",
    "SoundFigures": "sounds",
    "playing": "stage",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"{__name__} has no {name}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
