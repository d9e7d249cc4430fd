"""The page on streaming from an adapter: its programs run as they are written."""

import re
from pathlib import Path
from typing import Any

import openrois_media
import pytest
from openrois_media import AudioSource, AudioUplink, EncodedSource, Stream, VideoSource

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/how-to/streams.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def guide() -> dict[str, Any]:
    """What all pieces define, one after the other."""
    defined: dict[str, Any] = {"__name__": "guide"}
    for number, piece in enumerate(re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)):
        exec(compile(piece, f"docs/how-to/streams.md, piece {number}", "exec"), defined)
    return defined


async def test_its_noise_is_a_picture(guide: dict[str, Any]) -> None:
    async with guide["noise"].open() as frames:
        picture = await anext(frames)
    assert (picture.width, picture.height, picture.format) == (320, 240, "rgb24")
    assert picture.data.std() > 60


def test_its_sources_are_sources(guide: dict[str, Any]) -> None:
    assert isinstance(guide["camera"], VideoSource)
    assert isinstance(guide["film"], EncodedSource)
    assert isinstance(guide["talk"], Stream)
    assert isinstance(guide["talk"].source, AudioSource)
    assert isinstance(guide["talk"].uplink, AudioUplink)


def test_its_table_names_what_there_is() -> None:
    named = re.findall(r"^\|[^|]*\| `(\w+)\(", PAGE, re.MULTILINE)
    assert len(named) == 9
    assert set(named) <= set(openrois_media.__all__)


def test_other_names_are_not_there() -> None:
    with pytest.raises(AttributeError, match="openrois_media has no Camera"):
        _ = openrois_media.Camera
