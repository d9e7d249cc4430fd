"""Distributions that are built once for the tests of a run."""

import shutil
from pathlib import Path

import pytest

from tests.support.installations import Built, build_wheel
from tests.support.once import once, shared_folder
from tests.support.packages import ROOT, tracked
from tools.release.contents import PAGE


@pytest.fixture(scope="session")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tracked files, without what has been built among them: a fresh clone, with what is not committed yet."""
    folder = tmp_path_factory.mktemp("clone") / "openrois"
    for name in tracked():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    return folder


@pytest.fixture(scope="session")
def without_page(clone: Path, tmp_path_factory: pytest.TempPathFactory) -> Built:
    """A wheel of a clone in which the page was not built; a clone of another process is the same."""
    shared = shared_folder(tmp_path_factory, "distributions")
    return Built.read(once(shared / "without_page", lambda folder: build_wheel(clone, folder)))


@pytest.fixture(scope="session")
def wheel(without_page: Built) -> Path:
    """A wheel of the product."""
    return without_page.wheel


@pytest.fixture(scope="session")
def with_page(clone: Path, without_page: Built) -> Path:
    """A clone in which the page was built."""
    assert without_page.wheel.is_file(), "the wheel without the page is built before"
    page = clone / "web_demo" / PAGE
    page.parent.mkdir()
    page.write_text("<html></html>", encoding="utf-8")
    return clone
