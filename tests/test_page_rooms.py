"""The rooms of the page and of the TypeScript SDK: their imports go one way."""

import os
import re
from pathlib import Path

import pytest

WEB = Path(__file__).parents[1] / "web_demo"
LAYERS = {
    "app": ("", "panels", "inspector map senses", "dom", "model"),
    "sdk": ("", "media", "input", "rois", "jsonrpc"),
}
"""By folder, the highest first: a room imports from itself and from lower ones. Those in one line know nothing of each
other; the folder's own modules are the room without a name."""

_IMPORT = re.compile(r'(?:from|import)\s*\(?\s*"(\.[^"]+\.ts)"')


def room_of(module: Path) -> str:
    return module.parts[0] if len(module.parts) > 1 else ""


def imports(folder: Path) -> set[tuple[Path, Path]]:
    """Return which modules of a folder import which, from the folder on."""
    found = set()
    for path in folder.rglob("*.ts"):
        for name in _IMPORT.findall(path.read_text(encoding="utf-8")):
            target = Path(os.path.normpath(path.parent / name))
            if target.is_relative_to(folder):
                found.add((path.relative_to(folder), target.relative_to(folder)))
    return found


@pytest.mark.parametrize("name", LAYERS)
def test_imports_go_one_way(name: str) -> None:
    height = {room: -depth for depth, line in enumerate(LAYERS[name]) for room in line.split() or [""]}
    folder = WEB / name
    rooms = {path.parent.name for path in folder.glob("*/*.ts")} | {""}
    assert rooms == height.keys(), "every room has its layer"
    wrong = [
        f"{importer} imports {imported}"
        for importer, imported in sorted(imports(folder))
        if (one := room_of(importer)) != (other := room_of(imported)) and height[one] <= height[other]
    ]
    assert not wrong


def test_the_sdk_knows_nothing_of_the_page() -> None:
    for path in (WEB / "sdk").rglob("*.ts"):
        assert not re.search(r'"[./]*/app/', path.read_text(encoding="utf-8")), path
