"""Installations of the product, each in a virtual environment of its own, as users make them."""

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Self

from openrois.extras import EXTRAS
from tests.support.packages import ROOT

__all__ = [
    "APART",
    "TEST_TOOLS",
    "Built",
    "Installation",
    "build_wheel",
    "files_marked_for",
    "installed_size",
    "new_installation",
]

_CONSTRAINTS: Final = ROOT / "constraints.txt"
_SAID: Final = "said.txt"
APART: Final = {"livekit": "livekit-agents", "pipecat": "pipecat-ai"}
"""Extras with a list of versions of their own, `constraints-<extra>.txt`, and the distribution that each is for."""
TEST_TOOLS: Final = ("pytest", "pytest-asyncio", "pytest-timeout", "hypothesis", "psutil")
"""What runs tests, beside the extra that they are for."""


def _environment(more: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the environment without what leads to the checkout's packages, or to another environment's."""
    left_out = ("PYTHONPATH", "VIRTUAL_ENV", "OPENROIS_REQUIRE_ALL")
    kept = {name: value for name, value in os.environ.items() if name not in left_out}
    # All seeds are tried in the checkout: here it is found out whether anything is missing.
    kept["OPENROIS_SEEDS"] = "1"
    versions = str(_CONSTRAINTS)
    return {**kept, "PIP_CONSTRAINT": versions, "PIP_BUILD_CONSTRAINT": versions, **(more or {})}


def run(*words: str | Path, cwd: Path, more: Mapping[str, str] | None = None) -> "subprocess.CompletedProcess[str]":
    """Run a program to its end."""
    return subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=_environment(more),
        capture_output=True,
        text=True,
        check=False,
        timeout=540,
    )


@dataclass(frozen=True, slots=True)
class Built:
    """A wheel.

    Attributes:
        wheel: it.
        said: what was said while it was built.
    """

    wheel: Path
    said: str

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Return what `build_wheel` has put into a folder."""
        (wheel,) = folder.glob("openrois-*.whl")
        return cls(wheel, (folder / _SAID).read_text(encoding="utf-8"))


def build_wheel(source: Path, folder: Path) -> Built:
    """Build a wheel from a clone or an sdist, and put it into a new folder.

    Raises:
        AssertionError: it cannot be built.
    """
    words = (sys.executable, "-m", "pip", "wheel", "-v", "--disable-pip-version-check", "--no-deps", "-w", folder)
    folder.mkdir()
    built = run(*words, source, cwd=folder)
    assert built.returncode == 0, built.stderr[-3000:]
    (folder / _SAID).write_text(built.stdout + built.stderr, encoding="utf-8")
    return Built.read(folder)


class Installation:
    """A virtual environment.

    Attributes:
        folder: where it is.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def new(cls, folder: Path) -> Self:
        """Make an empty environment."""
        made = run(sys.executable, "-m", "venv", folder, cwd=folder.parent)
        assert made.returncode == 0, made.stdout + made.stderr
        return cls(folder)

    def program(self, name: str) -> Path:
        """Return the path of a program of it."""
        return self.folder / "bin" / name

    def install(self, *requirements: str, versions: Path = _CONSTRAINTS) -> None:
        """Install distributions, in the versions that were tested together.

        Raises:
            AssertionError: pip has failed.
        """
        words: tuple[str | Path, ...] = (self.program("pip"), "install", "-q", *requirements)
        done = run(*words, cwd=self.folder, more={"PIP_CONSTRAINT": str(versions)})
        assert done.returncode == 0, done.stderr[-3000:]

    def install_product(self, archive: Path, extra: str = "") -> None:
        """Install the product from a wheel or sdist, with an extra.

        Raises:
            AssertionError: pip has failed.
        """
        versions = ROOT / f"constraints-{extra}.txt" if extra in APART else _CONSTRAINTS
        self.install(f"openrois{f'[{extra}]' if extra else ''} @ {archive.as_uri()}", versions=versions)

    def run(self, name: str, *words: str | Path) -> "subprocess.CompletedProcess[str]":
        """Run a program of it, away from the checkout."""
        return run(self.program(name), *words, cwd=self.folder)

    def run_tests(self, extra: str) -> "subprocess.CompletedProcess[str]":
        """Run the tests that are marked for an extra and need no other one, with this installation's product."""
        others = sorted(name for name in _names_of_marks() if not _modules(name) <= _modules(extra))
        selected = " and ".join((f"extra(name='{extra}')", *(f"not extra(name='{name}')" for name in others)))
        (packages,) = self.folder.glob("lib/python*/site-packages")
        # The checkout has the tests; its packages stand behind the installed ones.
        (packages / "checkout.pth").write_text(f"{ROOT}\n", encoding="utf-8")
        words = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-o", "pythonpath=", "-m", selected)
        files = files_marked_for(extra)
        return run(self.program("python"), *words, *files, cwd=ROOT, more={"PYTHONSAFEPATH": "1"})


@contextmanager
def new_installation() -> Iterator[Installation]:
    """Make an empty environment, which is removed with the block: some have hundreds of megabytes."""
    with TemporaryDirectory(prefix="openrois-installation-") as folder:
        yield Installation.new(Path(folder) / "venv")


def installed_size(folder: Path) -> int:
    """Return the bytes that a folder takes on disk, as `du` counts them."""
    return 512 * sum(path.lstat().st_blocks for path in (folder, *folder.rglob("*")))


@cache
def _marked() -> Mapping[str, frozenset[str]]:
    """Return the names of the extras for which a test file has marks."""
    found = {}
    for path in sorted((*(ROOT / "tests").rglob("test_*.py"), *(ROOT / "tests").rglob("conftest.py"))):
        words = path.read_text(encoding="utf-8").split('mark.extra(name="')[1:]
        if words:
            found[str(path.relative_to(ROOT))] = frozenset(word.partition('"')[0] for word in words)
    return found


def _names_of_marks() -> set[str]:
    return {name for names in _marked().values() for name in names}


def _modules(extra: str) -> set[str]:
    return {extra} if extra == "dev" else set(EXTRAS.get(extra, ()))


def files_marked_for(extra: str) -> list[str]:
    """Return the test files with tests for an extra; a mark in a conftest is one of all files beside it."""
    found = set()
    for path in (Path(path) for path, names in _marked().items() if extra in names):
        beside = (ROOT / path.parent).glob("test_*.py") if path.name == "conftest.py" else (ROOT / path,)
        found |= {str(each.relative_to(ROOT)) for each in beside}
    return sorted(found)
