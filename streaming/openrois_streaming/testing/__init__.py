"""Testing kit for authors of engines and viewers: bad networks, known pictures and sounds, and measurements.

    from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink

Nothing here needs a test runner; `plugin` is for pytest. `docs/how-to/testing.md` has examples. Names are imported on
first use, because the plugin is imported in every run of a project's tests, and the media plane takes half a second.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from openrois_streaming.errors import needing_libraries

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
    with needing_libraries():
        return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
