"""Which backend is used."""

import re
from collections.abc import Callable, Iterable
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_body.backends import chosen
from openrois_body.vision.backends import FINDERS
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.view import View
from openrois_streaming.source.source import RawVideo


class Better(CascadeFinder):
    pass


class Elsewhere(CascadeFinder):
    def available(self) -> tuple[bool, str]:
        return False, "install something"


def installed(*names: str) -> Callable[..., Iterable[EntryPoint]]:
    """Entry points of these classes here, or of what is not there."""
    return lambda group: [EntryPoint(name, f"{__name__}:{name}", group) for name in names]


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    places = {"Better": Better, "Elsewhere": Elsewhere}

    def load(self: EntryPoint) -> object:
        return places[self.name]

    monkeypatch.setattr(EntryPoint, "load", load)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ((), CascadeFinder),
        (("Better",), Better),
        (("Elsewhere", "Better"), Better),
        (("Elsewhere", "Gone"), CascadeFinder),
    ],
)
def test_the_first_that_works_and_else_the_offline_one(names: tuple[str, ...], expected: type) -> None:
    assert type(chosen(FINDERS, CascadeFinder, installed(*names))) is expected


def test_unusable_backend_is_logged_with_its_reason(caplog: pytest.LogCaptureFixture) -> None:
    chosen(FINDERS, CascadeFinder, installed("Elsewhere"))
    assert "install something" in caplog.text


def test_the_backend_that_the_guide_shows() -> None:
    guide = (Path(__file__).parents[3] / "docs" / "how-to" / "senses.md").read_text(encoding="utf-8")
    (piece,) = (
        each for each in re.findall(r"^```python\n(.*?)^```$", guide, re.DOTALL | re.MULTILINE) if "Finder" in each
    )
    defined: dict[str, Any] = {}
    exec(compile(piece, "docs/how-to/senses.md", "exec"), defined)
    finder = defined["Finder"]()
    assert finder.available() == (True, "")
    picture = np.zeros((120, 160, 3), np.uint8)
    picture[30, 40] = 255
    (face,) = finder.find(View(RawVideo(picture, "bgr24", 160, 120, 0, 0.0)), [])
    assert face.box.centre == pytest.approx((0.25, 0.25))
