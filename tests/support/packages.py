"""The packages of the product, as the folders say."""

from pathlib import Path
from typing import Final

__all__ = ["ROOT", "packages"]

ROOT: Final = Path(__file__).parents[2]


def packages() -> tuple[str, ...]:
    """Return the folders of all packages, from the repository's folder on."""
    found = (path.parent for path in (ROOT / "openrois/__init__.py", *ROOT.glob("*/openrois_*/__init__.py")))
    return tuple(sorted(str(path.relative_to(ROOT)) for path in found))
