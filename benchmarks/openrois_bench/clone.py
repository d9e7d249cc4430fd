"""The clone of the repository that this package stands in: some programs need more of it than a wheel has."""

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Final

__all__ = ["ROOT", "packages_of", "require_clone"]

ROOT: Final = Path(__file__).parents[2]
"""The folder of the clone."""


def require_clone() -> None:
    """End the program, with the remedy, where there is no clone or it is not the present folder.

    Raises:
        SystemExit: there are no tests, or they cannot be imported.
    """
    if not (ROOT / "tests/support").is_dir() or find_spec("tests") is None:
        sys.exit("this program uses the tests of the repository: run it in the folder of a clone")


def packages_of(clone: Path) -> list[Path]:
    """Return the folders that Python has to look in for the packages of a clone."""
    return [clone, *sorted({package.parents[1] for package in clone.glob("*/openrois_*/__init__.py")})]
