"""Every list of the packages names those that there are."""

import tomllib
from pathlib import Path
from typing import Any

from tests import test_house
from tests.packaging import test_imports

ROOT = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
NOT_SHIPPED = {"codegen/openrois_codegen"}
"""What is for those who build the product."""


def packages() -> set[str]:
    """Return the folders of all packages, from the repository's folder on."""
    found = {path.parent for path in ROOT.glob("*/openrois_*/__init__.py")} | {ROOT / "openrois"}
    return {str(path.relative_to(ROOT)) for path in found}


def names() -> set[str]:
    return {Path(path).name for path in packages()}


def test_the_wheel_carries_them() -> None:
    assert set(PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]) == packages() - NOT_SHIPPED


def test_they_can_be_imported_from_a_checkout() -> None:
    folders = {str(Path(path).parent) for path in packages()}
    assert set(PROJECT["tool"]["hatch"]["build"]["dev-mode-dirs"]) == folders
    assert {*PROJECT["tool"]["mypy"]["mypy_path"], "."} == folders


def test_their_types_are_checked() -> None:
    checked = PROJECT["tool"]["mypy"]["files"]
    assert all(any(path == each or path.startswith(f"{each}/") for each in checked) for path in packages())


def test_their_imports_are_checked() -> None:
    assert set(PROJECT["tool"]["importlinter"]["root_packages"]) == names()


def test_their_branches_are_counted() -> None:
    # The page's package is a folder of files.
    assert set(PROJECT["tool"]["coverage"]["run"]["source_pkgs"]) == names() - {"openrois_web_demo"}


def test_tests_look_at_all_of_them() -> None:
    assert {path.removesuffix("/") for path in test_house.PACKAGES} == packages()
    assert set(test_imports.PACKAGES) == packages()
