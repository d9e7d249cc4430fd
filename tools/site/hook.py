"""A hook of mkdocs: pages of the repository that lie outside `docs` are on the site too, and links lead to them.

A link to a file that is no page leads to a copy of it below `files`; of a link to a folder the text stays.
"""

import re
from functools import partial
from os.path import normpath, relpath
from pathlib import Path, PurePosixPath
from typing import Any, Final

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

__all__ = ["OUTSIDE", "on_files", "on_page_content", "on_page_markdown"]

ROOT: Final = Path(__file__).parents[2]

OUTSIDE: Final = {
    "ARCHITECTURE.md": "explanation/architecture.md",
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "README.md": "index.md",
    "SECURITY.md": "project/security.md",
    "avatar_adapter/godot/README.md": "how-to/godot.md",
    "avatar_adapter/unity/README.md": "how-to/unity.md",
    "benchmarks/README.md": "explanation/benchmarks.md",
    "sdk/csharp/README.md": "how-to/csharp.md",
    "tests/README.md": "project/tests.md",
    "web_demo/sdk/README.md": "how-to/typescript.md",
}
"""Pages by their path in the repository, and where they stand on the site; README.md is the home page's sister."""

_PLACES: Final = {place: path for path, place in OUTSIDE.items() if path != "README.md"}
_LINK: Final = re.compile(r"(!?)\[([^\]]*(?:\[[^\]]*\][^\]]*)*)\]\(([^)\s#]*)(#[^)\s]*)?\)")
_CODE: Final = re.compile(r"^```.*?^```$|`[^`\n]+`", re.DOTALL | re.MULTILINE)

_LONG_CODE: Final = re.compile(r"(?<=<code>)[^<\s]{20,}(?=</code>)")
_PART_END: Final = re.compile(r"(::|[./_](?=\w))")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that lie outside `docs`, and the files that links lead to."""
    for place, path in _PLACES.items():
        files.append(File.generated(config, place, abs_src_path=str(ROOT / path)))
    # What pages link to is known once all of them are read.
    for page in files.documentation_pages():
        for _, _, link, _ in _LINK.findall(_without_examples(page.content_string)[0]):
            target = _target(page.src_uri, link)
            if target and (ROOT / target).is_file() and _place(target).startswith("files/"):
                copied = _place(target)
                if files.get_file_from_path(copied) is None:
                    files.append(File.generated(config, copied, abs_src_path=str(ROOT / target)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Let the links of a page lead to where their targets stand on the site."""
    text, examples = _without_examples(markdown)
    text = _LINK.sub(partial(_linked, page.file.src_uri), text)
    return re.sub("\0(\\d+)\0", lambda found: examples[int(found[1])], text)


def on_page_content(html: str, page: Page, **_: Any) -> str:
    """Let long names in tables break where their parts end, and give the home page the whole width."""
    if page.file.src_uri == "index.md":
        page.meta["hide"] = ["navigation", "toc"]
    return _LONG_CODE.sub(lambda code: _PART_END.sub(r"\1<wbr>", code[0]), html)


def _without_examples(markdown: str) -> tuple[str, list[str]]:
    """Return a page with a number in the place of each piece of code that has a link in it, and these pieces."""
    examples: list[str] = []

    def numbered(code: re.Match[str]) -> str:
        if "](" not in code[0]:
            return code[0]
        examples.append(code[0])
        return f"\0{len(examples) - 1}\0"

    return _CODE.sub(numbered, markdown), examples


def _linked(page: str, link: re.Match[str]) -> str:
    target = _target(page, link[3])
    if not target:
        return link[0]
    if (ROOT / target).is_dir():
        return link[2]
    there = relpath(_place(target), PurePosixPath(page).parent)
    return f"{link[1]}[{link[2]}]({there}{link[4] or ''})"


def _target(page: str, link: str) -> str:
    """Return the path in the repository that a link of a page means; empty where it leads elsewhere."""
    if not link or "://" in link or link.startswith("mailto:"):
        return ""
    origin = _PLACES.get(page, f"docs/{page}")
    return normpath(PurePosixPath(origin).parent / link)


def _place(target: str) -> str:
    """Return where a file of the repository stands on the site."""
    if target.startswith("docs/"):
        return target.removeprefix("docs/")
    return OUTSIDE.get(target, f"files/{target}")
