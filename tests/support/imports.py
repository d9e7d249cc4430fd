"""The imports of the product, for tests of its directions; it needs import-linter's library."""

from functools import cache
from pathlib import Path

import grimp

from tests.support.packages import packages

__all__ = ["import_graph"]


@cache
def import_graph() -> grimp.ImportGraph:
    """Return the imports of all packages, among themselves and of other distributions."""
    return grimp.build_graph(*(Path(package).name for package in packages()), include_external_packages=True)
