"""What is in a wheel and in an sdist, from a clone with and without the built page."""

import re
from collections.abc import Iterable
from email import message_from_bytes
from email.message import Message
from pathlib import Path
from typing import Final

import pytest

from openrois.version import __version__
from tests.support.installations import Built, build_wheel
from tests.support.packages import NOT_SHIPPED, ROOT, packages
from tools.release.__main__ import build
from tools.release.contents import PAGE, missing_page, read_archive

pytestmark = pytest.mark.timeout(600)

INDEXES: Final = "|".join(
    rf"{name}\.{top}"
    for name, top in (("pypi", "org"), ("pythonhosted", "org"), (r"registry\.npmjs", "org"), (r"registry\.yarnpkg", ""))
)
UNWANTED: Final = {
    "the address of a package index": re.compile(INDEXES),
    "an absolute path of a machine": re.compile(r"(?<![\w.])/(?:home|root|work)/"),
    "a path that leads out of the sources": re.compile(r"(?<![\w./-])\.{0,2}/?shared/"),
}
"""What binds a distribution to the place where it was made."""
OWN: Final = Path(__file__).relative_to(ROOT).as_posix()


def metadata(wheel: Path) -> Message:
    """Return the metadata of a wheel."""
    (content,) = [content for name, content in read_archive(wheel) if name.endswith(".dist-info/METADATA")]
    return message_from_bytes(content)


def description(wheel: Path) -> str:
    """Return the long description of a wheel, as package indexes show it."""
    text = metadata(wheel).get_payload(decode=True)
    assert isinstance(text, bytes)
    return text.decode()


def unwanted(files: Iterable[tuple[str, bytes]]) -> list[tuple[str, str]]:
    """Return the files that hold what they must not, and what that is."""
    found = []
    for name, content in files:
        try:
            text = content.decode("utf-8")
        except UnicodeDecodeError:
            continue
        found += [(name, what) for what, pattern in UNWANTED.items() if name != OWN and pattern.search(text)]
    return found


@pytest.mark.long
def test_a_wheel_without_the_page_is_built_with_a_warning(without_page: Built) -> None:
    assert "This wheel has no web page: run `make page` first to include it." in without_page.said
    assert missing_page(without_page.wheel) == f"{without_page.wheel.name} has no web page: run `make page` first"


def test_it_carries_every_package_and_what_each_needs(wheel: Path) -> None:
    names = {name for name, _ in read_archive(wheel)}
    for package in set(packages()) - NOT_SHIPPED:
        assert f"{Path(package).name}/__init__.py" in names
    assert "openrois_avatar/engines/godot/project/project.godot" in names
    assert {name.partition("/")[0] for name in names if "." not in name.partition("/")[0]} == {
        Path(package).name for package in set(packages()) - NOT_SHIPPED
    }


def test_it_says_what_it_is(wheel: Path) -> None:
    told = metadata(wheel)
    assert told["Version"] == __version__
    assert told["License-Expression"] == "Apache-2.0"
    assert {"Source", "Documentation", "Changelog", "Issues"} == {
        url.partition(",")[0] for url in told.get_all("Project-URL", [])
    }
    pythons = {f"Programming Language :: Python :: 3.{minor}" for minor in (11, 12, 13)}
    assert pythons <= set(told.get_all("Classifier", []))


def test_the_links_of_its_description_lead_somewhere_from_anywhere(wheel: Path) -> None:
    text = description(wheel)
    links = re.findall(r"!?\[[^\]]*\]\(([^)\s]+)\)", text)
    assert len(links) > 10
    assert [link for link in links if not link.startswith(("https://", "#"))] == []
    (source,) = [url.partition(", ")[2] for url in metadata(wheel).get_all("Project-URL", []) if "Source" in url]
    for link in links:
        kind, _, path = link.removeprefix(f"{source}/").partition(f"/v{__version__}/")
        if kind in ("raw", "blob"):
            assert (ROOT / path.partition("#")[0]).exists(), link
    assert "![" not in text or f"{source}/raw/v{__version__}/docs/" in text


def test_the_plugin_for_pytest_is_loaded_by_nobody_who_has_not_asked(wheel: Path) -> None:
    (points,) = [content for name, content in read_archive(wheel) if name.endswith("entry_points.txt")]
    assert b"pytest11" not in points


def test_nothing_in_it_is_bound_to_a_place(clone: Path, wheel: Path) -> None:
    # An sdist holds all that is tracked.
    tracked = [path for path in clone.rglob("*") if path.is_file()]
    assert unwanted((path.relative_to(clone).as_posix(), path.read_bytes()) for path in tracked) == []
    assert unwanted(read_archive(wheel)) == []


@pytest.mark.long
def test_with_the_page_both_carry_it_and_are_bound_to_no_place(with_page: Path, tmp_path: Path) -> None:
    archives = build(with_page, tmp_path / "dist", tmp_path)
    assert [archive.name for archive in archives] == [
        f"openrois-{__version__}.tar.gz",
        f"openrois-{__version__}-py3-none-any.whl",
    ]
    assert [missing_page(archive) for archive in archives] == ["", ""]
    assert [unwanted(read_archive(archive)) for archive in archives] == [[], []]
    sdist, wheel = archives
    names = {name for name, _ in read_archive(sdist)}
    assert {"pyproject.toml", "hatch_build.py", "constraints.txt", "tests/conftest.py", f"web_demo/{PAGE}"} <= names
    # What is built from the sdist is the same.
    again = build_wheel(sdist, tmp_path / "again").wheel
    assert {name for name, _ in read_archive(again)} == {name for name, _ in read_archive(wheel)}


@pytest.mark.parametrize(
    "text", ["https://py" + "pi.org/simple", "cd /ho" + "me/me/openrois", "see ../sha" + "red/x.md"]
)
def test_what_binds_it_to_a_place_would_be_seen(text: str) -> None:
    assert [what for what, pattern in UNWANTED.items() if pattern.search(text)]
