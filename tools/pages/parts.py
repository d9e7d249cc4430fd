"""Printed parts of a page: what stands between two marks is replaced, the text around them is written by hand."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

__all__ = ["Part", "UnknownPart", "filled", "outdated"]

Part = Callable[[], list[str]]
"""Returns the lines of a printed part, without its marks."""

_MARKED = re.compile(r"(<!-- printed: ([\w-]+) -->\n).*?(<!-- printed until here -->)", re.DOTALL)


class UnknownPart(Exception):
    """A page has a mark for a part that is not printed."""


def filled(page: str, parts: Mapping[str, Part]) -> str:
    """Return a page with all its printed parts as they are now.

    Raises:
        UnknownPart: a mark names none of `parts`.
    """

    def printed(found: re.Match[str]) -> str:
        if found[2] not in parts:
            raise UnknownPart(f"the part {found[2]!r} is unknown; there are {', '.join(sorted(parts))}")
        return found[1] + "\n".join(["", *parts[found[2]](), "", ""]) + found[3]

    return _MARKED.sub(printed, page)


def outdated(root: Path, pages: Mapping[str, str]) -> list[str]:
    """Return the paths of the pages that are not as their text says."""
    return [path for path, text in pages.items() if (root / path).read_text(encoding="utf-8") != text]
