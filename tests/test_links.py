"""Every link in the repository's pages leads somewhere, and every file that they name is there."""

import re
from collections import Counter
from collections.abc import Iterator
from functools import cache

import pytest

from tests.support.packages import ROOT, tracked
from tests.test_house import source

PAGES = tuple(path for path in tracked() if path.endswith(".md"))
FOLDERS = tuple(sorted({path.partition("/")[0] for path in tracked() if "/" in path}))


def prose(path: str) -> str:
    """Return a page without its examples."""
    return re.sub(r"^```.*?^```$", "", source(path), flags=re.DOTALL | re.MULTILINE)


@cache
def anchors(path: str) -> frozenset[str]:
    """Return what can stand behind # in a link to a page: its headings, as GitHub writes them."""
    found: Counter[str] = Counter()
    names = set()
    for heading in re.findall(r"^#+ +(.+?) *$", prose(path), re.MULTILINE):
        shown = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        names.add(f"{name}-{found[name]}" if found[name] else name)
        found[name] += 1
    return frozenset(names)


def dead_links(path: str) -> list[str]:
    """Return the links of a page to what is not in the repository."""
    dead = []
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(path)):
        if link.startswith("https://"):
            continue
        file, _, anchor = link.partition("#")
        target = ((ROOT / path).parent / file).resolve() if file else ROOT / path
        name = target.relative_to(ROOT).as_posix() if target.is_relative_to(ROOT) else ""
        there = name in tracked() or any(each.startswith(f"{name}/") for each in tracked())
        if not there or (anchor and anchor not in anchors(name)):
            dead.append(link)
    return dead


def missing_files(path: str) -> list[str]:
    """Return the files that a page names, from the top of the repository or from beside it, and that are not there."""
    named = re.findall(rf"`((?:{'|'.join(FOLDERS)})/(?:[\w./-]*[\w-]\.\w+|[\w./-]*/))`", prose(path))
    places = (ROOT, (ROOT / path).parent)
    return [name for name in named if not any((place / name).exists() for place in places)]


@pytest.mark.parametrize("path", PAGES)
def test_links_lead_somewhere(path: str) -> None:
    assert dead_links(path) == []


@pytest.mark.parametrize("path", PAGES)
def test_named_files_are_there(path: str) -> None:
    assert missing_files(path) == []


def test_clauses_of_the_manifest_are_sections_of_the_wire() -> None:
    for page in ("wire.md", "adapter-wire.md"):
        headings = set(re.findall(r"^#+ (.+)$", prose(f"docs/reference/{page}"), re.MULTILINE))
        cited = set(re.findall(rf"\| {re.escape(page)}: ([^|]+?) \|", source("docs/reference/conformance.md")))
        assert cited
        assert cited <= headings


@pytest.fixture
def wrong_page(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    text = "# A `b`: c\n[1](README.md) [2](gone.md) [3](#a-b-c) [4](#d) `docs/gone.py` `docs/reference/wire.md`\n"
    monkeypatch.setattr("tests.test_links.source", lambda _path: text)
    anchors.cache_clear()
    yield
    anchors.cache_clear()


@pytest.mark.usefixtures("wrong_page")
def test_what_is_gone_is_found() -> None:
    assert dead_links("README.md") == ["gone.md", "#d"]
    assert missing_files("README.md") == ["docs/gone.py"]
