"""Which backend is used."""

from collections.abc import Callable, Iterable
from importlib.metadata import EntryPoint

import pytest
from openrois_avatar.vision.backends import FINDERS, chosen
from openrois_avatar.vision.cascades import CascadeFinder


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


def test_what_does_not_work_is_logged_with_its_reason(caplog: pytest.LogCaptureFixture) -> None:
    chosen(FINDERS, CascadeFinder, installed("Elsewhere"))
    assert "install something" in caplog.text
