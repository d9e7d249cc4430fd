"""The pictures of the documentation: each has a maker and a record, and one whose sources have changed is named."""

import re
from pathlib import Path

import pytest

from tools.pictures.architecture import PACKAGES, draw
from tools.pictures.record import FOLDER, PICTURES, ROOT, digest, recorded, stale

MOST = 3_000_000
"""Bytes of the moving picture; others are smaller by far."""


def test_every_picture_has_a_maker_and_a_record() -> None:
    there = {path.name for path in FOLDER.iterdir() if path.suffix != ".json"}
    assert there == set(PICTURES) == set(recorded())


def test_every_picture_is_shown() -> None:
    pages = [ROOT / "README.md", ROOT / "mkdocs.yml", *(ROOT / "docs").rglob("*.md")]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert [name for name in PICTURES if f"pictures/{name}" not in text] == []


def test_no_picture_lies_elsewhere() -> None:
    found = {
        path.relative_to(ROOT).parent for kind in ("png", "svg", "webp") for path in (ROOT / "docs").rglob(f"*.{kind}")
    }
    assert found == {Path("docs/pictures")}


def test_architecture_is_as_drawn_and_has_all_packages_but_those_for_developers() -> None:
    assert (FOLDER / "architecture.svg").read_text(encoding="utf-8") == draw()
    packages = {path.parent.name for path in ROOT.glob("*/openrois_*/__init__.py")} | {"openrois"}
    others = {"openrois_demo", "openrois_conformance", "openrois_bench", "openrois_codegen"}
    assert set(PACKAGES) == packages - others


def test_they_are_small_enough() -> None:
    sizes = {path.name: path.stat().st_size for path in FOLDER.iterdir()}
    assert [name for name, size in sizes.items() if size > (MOST if name == "demo.webp" else 400_000)] == []


def test_the_moving_picture_moves() -> None:
    text = (FOLDER / "demo.webp").read_bytes()
    assert text[8:12] == b"WEBP"
    assert len(re.findall(b"ANMF", text)) > 30


def test_sources_of_all_are_there() -> None:
    assert all(digest(patterns) or not patterns for patterns in PICTURES.values())


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    for name, text in (("a.css", "one"), ("b.css", "two")):
        (tmp_path / name).write_text(text)
    return tmp_path


def test_what_changed_is_another_state(sources: Path) -> None:
    before = digest(["*.css"], sources)
    (sources / "b.css").write_text("three")
    assert digest(["*.css"], sources) != before


def test_what_was_moved_is_the_same(sources: Path) -> None:
    before = digest(["**/*.css"], sources)
    (sources / "below").mkdir()
    (sources / "b.css").rename(sources / "below/c.css")
    assert digest(["**/*.css"], sources) == before


def test_an_import_from_elsewhere_is_the_same(sources: Path) -> None:
    (sources / "a.py").write_text("from one import a\nprint(a)\n")
    before = digest(["*.py"], sources)
    (sources / "a.py").write_text("from two import a\nprint(a)\n")
    assert digest(["*.py"], sources) == before


def test_a_pattern_without_a_file_is_an_error(sources: Path) -> None:
    with pytest.raises(FileNotFoundError, match="correct PICTURES"):
        digest(["*.ts"], sources)


def test_a_picture_without_a_record_is_stale() -> None:
    assert stale({}) == list(PICTURES)[: len(stale({}))]
    assert stale(recorded() | {"logo.svg": "another"})[-1] == "logo.svg"
