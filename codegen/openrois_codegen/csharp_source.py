"""C#: files, blocks and documentation comments, as both emitters write them.

Pure.
"""

import re
from collections.abc import Iterable, Sequence
from xml.sax.saxutils import escape

from openrois_codegen.names import first_paragraph, wrapped

__all__ = ["block", "documented", "source_file"]


def source_file(namespace: str, doc: str, parts: Iterable[str], *usings: str) -> str:
    """Return a file with these parts in one namespace."""
    head = f"// {doc} Written by `make generate`; edits are lost.\n"
    used = "".join(f"using {using};\n" for using in usings)
    body = "\n".join(_indented(part) for part in parts)
    return f"{head}{used}{chr(10) if used else ''}namespace {namespace}\n{{\n{body}}}\n"


def block(head: str, doc: str, members: Sequence[str], separator: str = "") -> str:
    """Return a documented head with members in braces."""
    body = separator.join(_indented(member) for member in members)
    return f"{documented(doc)}{head}\n{{\n{body}}}\n"


def documented(text: str) -> str:
    """Return a documentation comment of the first paragraph of a text; empty for none."""
    text = re.sub(r"`([^`]+)`", r"<c>\1</c>", escape(first_paragraph(text)))
    if not text:
        return ""
    if len(text) <= 90:
        return f"/// <summary>{text}</summary>\n"
    lines = "".join(f"/// {line}\n" for line in wrapped(text, 100))
    return f"/// <summary>\n{lines}/// </summary>\n"


def _indented(text: str) -> str:
    return "".join(f"    {line}" if line.strip() else line for line in text.splitlines(keepends=True))
