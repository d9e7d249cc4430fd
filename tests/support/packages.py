"""The packages of the product, their modules, and the files of the repository."""

import subprocess
from functools import cache
from pathlib import Path
from typing import Final

__all__ = ["NOT_SHIPPED", "ROOT", "modules", "packages", "tracked"]

ROOT: Final = Path(__file__).parents[2]
NOT_SHIPPED: Final = frozenset({"codegen/openrois_codegen"})
"""Packages for those who build the product."""


def packages() -> tuple[str, ...]:
    """Return the folders of all packages, from the repository's folder on."""
    found = (path.parent for path in (ROOT / "openrois/__init__.py", *ROOT.glob("*/openrois_*/__init__.py")))
    return tuple(sorted(str(path.relative_to(ROOT)) for path in found))


@cache
def tracked() -> tuple[str, ...]:
    """Return the paths of every tracked file that is there."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True, timeout=20)
    return tuple(path for path in listed.stdout.split("\0") if path and (ROOT / path).is_file())


def modules() -> list[str]:
    """Return the paths of the modules of all packages."""
    folders = tuple(f"{package}/" for package in packages())
    return [path for path in tracked() if path.endswith(".py") and path.startswith(folders)]
