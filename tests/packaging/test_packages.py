"""Every list of the packages names those that there are."""

import tomllib
from pathlib import Path
from typing import Any

from tests.support.packages import NOT_SHIPPED, ROOT, packages

PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def names() -> set[str]:
    return {Path(path).name for path in packages()}


def test_the_wheel_carries_them() -> None:
    assert set(PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]) == set(packages()) - NOT_SHIPPED


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
