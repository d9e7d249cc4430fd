"""The documentation site: it is built without a warning, and loads nothing from another host."""

import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.support.once import once, shared_folder
from tools.site.hook import OUTSIDE, on_page_markdown

ROOT = Path(__file__).parents[2]
LOADING = {
    "script": "src",
    "img": "src",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "audio": "src",
    "object": "data",
}
"""What a browser loads by itself, and the attribute that says from where; a link is a matter of its `rel`."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site, as `make docs` does: once for all processes of a run."""
    return once(shared_folder(tmp_path_factory, "documentation") / "site", _build)


def _build(folder: Path) -> None:
    command = [
        sys.executable,
        "-W",
        "ignore",
        "-m",
        "mkdocs",
        "build",
        "--strict",
        "--site-dir",
        str(folder),
    ]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=110)
    assert built.returncode == 0, built.stdout + built.stderr


class Loads(HTMLParser):
    """Collects the addresses that a page makes a browser load."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if tag == "link" and found.get("rel") not in ("prev", "next", "canonical"):
            self.addresses.append(found.get("href") or "")
        if tag in LOADING:
            self.addresses.append(found.get(LOADING[tag]) or "")


def is_elsewhere(address: str) -> bool:
    return re.match(r"(?:[a-z]+:)?//", address) is not None


def loads(page: str) -> list[str]:
    parser = Loads()
    parser.feed(page)
    return parser.addresses


@pytest.mark.long
def test_no_page_loads_anything_from_another_host(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert [address for address in loads(text) if is_elsewhere(address)] == [], page.name
        assert 'class="mermaid"' not in text, "the theme would load the library that draws it"


@pytest.mark.long
def test_no_style_loads_anything_from_another_host(site: Path) -> None:
    for style in site.rglob("*.css"):
        assert re.findall(r"(?:url\(|@import )[\"']?(?:https?:)?//[^)\s]*", style.read_text(encoding="utf-8")) == []


def test_an_address_elsewhere_is_found() -> None:
    page = '<link rel="stylesheet" href="//a.example/a.css"><script src="https://b.example/b.js"></script>'
    page += '<img src="c.png">'
    assert [is_elsewhere(address) for address in loads(page)] == [True, True, False]


@pytest.mark.long
def test_signatures_of_all_components_are_there(site: Path) -> None:
    from openrois.client import components

    page = (site / "reference/api/components.html").read_text(encoding="utf-8")
    assert [name for name in components.__all__ if f'id="openrois.client.components.{name}"' not in page] == []
    assert len(components.__all__) == 18, "seventeen, and what they have in common"


def api() -> Iterator[tuple[str, str]]:
    """Yield what the pages of the API show, by module and name."""
    for page in (ROOT / "docs/reference/api").glob("*.md"):
        for shown in re.findall(r"^::: ([\w.]+)$", page.read_text(encoding="utf-8"), re.MULTILINE):
            module, _, name = shown.rpartition(".")
            yield module, name


@pytest.mark.parametrize(
    "module",
    [
        "openrois.client",
        "openrois.adapter",
        "openrois.testing",
        "openrois_streaming.testing",
        "openrois_streaming.synthetic",
    ],
)
def test_all_that_a_package_promises_is_shown(module: str) -> None:
    promised = set(__import__(module, fromlist=["__all__"]).__all__)
    shown = {name for each, name in api() if each == module}
    again = {"BadParameter", "ComponentFailed", "OutOfResources", "RoISError", "TimedOut", "Unsupported"}
    codes = {"ComponentStatus", "ErrorType", "StreamStatus"}
    assert promised - shown - (again | codes if module == "openrois.adapter" else set()) == set()


def test_pages_outside_are_there() -> None:
    assert [path for path in OUTSIDE if not (ROOT / path).is_file()] == []


class FakePage:
    """A page of mkdocs, as far as the hook looks at it."""

    class file:  # noqa: N801
        src_uri = "how-to/engine.md"


def linked(markdown: str) -> str:
    return on_page_markdown(markdown, FakePage())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("written", "on_the_site"),
    [
        ("`b` and [a](../../tests/corpus) and `c`", "`b` and a and `c`"),
        ("[a](../reference/wire.md#input)", "[a](../reference/wire.md#input)"),
        ("[a](../../avatar_adapter/godot/README.md)", "[a](godot.md)"),
        ("[a](../../packaging/turnserver.conf)", "[a](../files/packaging/turnserver.conf)"),
        ("[`a`](../../packaging/turnserver.conf)", "[`a`](../files/packaging/turnserver.conf)"),
        ("[a](../../tests/corpus)", "a"),
        ("[a](https://example.org/)", "[a](https://example.org/)"),
        ("[a](#here)", "[a](#here)"),
        ("`[a](../../tests/corpus)`", "`[a](../../tests/corpus)`"),
        ("```\n[a](../../tests/corpus)\n```", "```\n[a](../../tests/corpus)\n```"),
    ],
)
def test_links_lead_to_the_site(written: str, on_the_site: str) -> None:
    assert linked(written) == on_the_site
