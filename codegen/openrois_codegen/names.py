"""Names and sentences as other languages write them. Pure."""

import re
import textwrap

__all__ = ["camel", "constant", "first_paragraph", "pascal", "wrapped"]


def camel(name: str) -> str:
    """Return snake_case as camelCase."""
    found = pascal(name)
    return found[:1].lower() + found[1:]


def pascal(name: str) -> str:
    """Return snake_case, dots too, as PascalCase."""
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[_.]", name))


def constant(name: str) -> str:
    """Return PascalCase as CONSTANT_CASE."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).upper()


def first_paragraph(text: str) -> str:
    """Return the first paragraph of a docstring as one line."""
    return " ".join(text.split("\n\n")[0].split())


def wrapped(text: str, width: int) -> list[str]:
    """Return text in lines of at most that many characters."""
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)
