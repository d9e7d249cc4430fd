"""The record of each picture of the documentation: its contents, and the state of its sources when it was made."""

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

__all__ = ["FOLDER", "PICTURES", "ROOT", "digest", "recorded", "stale", "write_record"]

ROOT: Final = Path(__file__).parents[2]
FOLDER: Final = ROOT / "docs" / "pictures"
RECORD: Final = FOLDER / "made_of.json"

_PAGE: Final = ("web_demo/app/index.html", "web_demo/app/styles/*.css", "web_demo/app/panels/*.ts")
_FIGURE: Final = (
    "avatar_adapter/openrois_avatar/engines/panda3d/**/*.py",
    "avatar_adapter/openrois_avatar/engines/figure/*.py",
    "avatar_adapter/openrois_avatar/engines/figure/**/*.npz",
    "avatar_adapter/openrois_avatar/engines/animation/*.py",
)

PICTURES: Final[Mapping[str, Iterable[str]]] = {
    "demo.webp": (*_PAGE, *_FIGURE, "tools/pictures/moving.py"),
    "demo.png": (*_PAGE, *_FIGURE),
    "map.png": (*_PAGE, *_FIGURE, "web_demo/app/map/*.ts"),
    "inspector.png": ("web_demo/app/styles/*.css", "web_demo/app/inspector/*.ts", "docs/examples/lamp_adapter.py"),
    "latency.svg": ("benchmarks/**/latency.json",),
    "congestion.svg": ("benchmarks/**/slow_viewer.json",),
    "architecture.svg": ("tools/pictures/architecture.py",),
    "logo.svg": ("web_demo/app/icon.svg",),
}
"""Each picture, and the files that it shows the state of, as patterns."""

_IMPORT: Final = re.compile(rb"^(?:import|from) .*\n", re.MULTILINE)
"""A line that changes when another module moves, and shows nothing."""

_ELSEWHERE: Final = frozenset({"node_modules", ".venv", "site", "dist"})


def digest(patterns: Iterable[str], root: Path = ROOT) -> str:
    """Return a digest of what the files say, wherever they lie: a file that is moved is the same file.

    Raises:
        FileNotFoundError: a pattern fits no file.
    """
    texts: list[bytes] = []
    for pattern in patterns:
        files = [path for path in root.glob(pattern) if _ELSEWHERE.isdisjoint(path.relative_to(root).parts)]
        if not files:
            raise FileNotFoundError(f"no file fits {pattern!r}: correct PICTURES in tools/pictures/record.py")
        texts += [hashlib.sha256(_IMPORT.sub(b"", path.read_bytes())).digest() for path in files]
    return hashlib.sha256(b"".join(sorted(texts))).hexdigest()[:16] if texts else ""


def recorded() -> dict[str, str]:
    """Return the digest of each picture's sources when it was made."""
    found: dict[str, str] = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.is_file() else {}
    return found


def stale(record: Mapping[str, str], root: Path = ROOT) -> list[str]:
    """Return the pictures whose sources are not what they were."""
    return [name for name, patterns in PICTURES.items() if record.get(name) != digest(patterns, root)]


def write_record(names: Iterable[str]) -> None:
    """Record that these pictures show the present state."""
    record = recorded() | {name: digest(PICTURES[name]) for name in names}
    RECORD.write_text(json.dumps(dict(sorted(record.items())), indent=1) + "\n", encoding="utf-8")
