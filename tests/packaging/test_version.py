"""One version, everywhere where one stands, and a section of the changelog for it."""

import json
import re

import pytest

from openrois.version import __version__
from tests.support.packages import ROOT

PACKAGES = ("avatar_adapter/unity/package.json", "web_demo/package.json", "web_demo/package-lock.json")


@pytest.mark.parametrize("path", [*PACKAGES, "web_demo/sdk/package.json"])
def test_packages_of_other_languages_have_the_same(path: str) -> None:
    assert json.loads((ROOT / path).read_text(encoding="utf-8"))["version"] == __version__


def test_the_changelog_begins_with_it_or_with_what_comes_next() -> None:
    sections = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sections[0] in (__version__, "Unreleased")
    assert __version__ in sections


def test_what_is_public_is_named_by_the_policy() -> None:
    policy = (ROOT / "docs/reference/versions.md").read_text(encoding="utf-8")
    recorded = json.loads((ROOT / "tests/public_surface.json").read_text(encoding="utf-8"))
    assert [name for name in recorded["names"] if f"`{name}`" not in policy] == []
