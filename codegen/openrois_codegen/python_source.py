"""Python as ruff writes it: lines that are broken where they are too long."""

from collections.abc import Iterable
from typing import Final

__all__ = ["call", "import_line"]

_WIDTH: Final = 120


def call(head: str, arguments: list[str], tail: str, indent: int) -> str:
    """Return `head(arguments)tail`, broken where it is too long for a line."""
    line = f"{head}({', '.join(arguments)}){tail}"
    if len(line) <= _WIDTH:
        return line
    margin = " " * (indent + 4)
    joined = f"{margin}{', '.join(arguments)}"
    if len(joined) <= _WIDTH:
        return f"{head}(\n{joined}\n{' ' * indent}){tail}"
    return "\n".join([f"{head}(", *(f"{margin}{argument}," for argument in arguments), f"{' ' * indent}){tail}"])


def import_line(module: str, names: Iterable[str]) -> str:
    """Return the import of names in the order of isort: constants, classes, functions."""
    ordered = sorted(names, key=lambda name: (not name.isupper(), not name[0].isupper(), name))
    line = f"from {module} import {', '.join(ordered)}"
    if len(line) <= _WIDTH:
        return line
    return "\n".join([f"from {module} import (", *(f"    {name}," for name in ordered), ")"])
