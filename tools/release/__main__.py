"""`python -m tools.release`: builds sdist and wheel into `dist`, installs each anew and runs the tutorial with it."""

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from tools.release.contents import missing_page
from tools.release.tutorial import TutorialFailed, run_tutorial

__all__ = ["build", "main"]

ROOT: Final = Path(__file__).parents[2]
DIST: Final = ROOT / "dist"
_BUILDERS: Final = ("hatchling", "editables")
_TEST_TOOLS: Final = ("pytest", "pytest-asyncio")


def main() -> int:
    """Build and try everything; return 0 where all of it works."""
    shutil.rmtree(DIST, ignore_errors=True)
    try:
        with tempfile.TemporaryDirectory(prefix="openrois-release-") as folder:
            archives = build(ROOT, DIST, Path(folder))
            if missing := [sentence for archive in archives if (sentence := missing_page(archive))]:
                print(*missing, sep="\n", file=sys.stderr)
                return 1
            for archive in archives:
                _try(archive, Path(folder) / archive.suffix.removeprefix("."))
    except (subprocess.CalledProcessError, TutorialFailed) as error:
        print(f"make dist: {error}", file=sys.stderr)
        return 1
    print(*(f"{archive.relative_to(ROOT)}: {archive.stat().st_size / 1e6:.1f} MB" for archive in archives), sep="\n")
    return 0


def build(source: Path, output: Path, folder: Path) -> list[Path]:
    """Build an sdist and a wheel, and return them.

    Args:
        source: a clone.
        output: where they are put.
        folder: where an environment for the build is made.

    Raises:
        subprocess.CalledProcessError: the build has failed.
    """
    environment = _environment(folder / "build", *_BUILDERS)
    # The environment's own: `python -m` would find a package of the clone with the same name first.
    words = (environment / "bin" / "hatchling", "build", "-d", output)
    subprocess.run([str(word) for word in words], cwd=source, check=True)
    return [*sorted(output.glob("openrois-*.tar.gz")), *sorted(output.glob("openrois-*.whl"))]


def _environment(folder: Path, *requirements: str) -> Path:
    """Make a virtual environment with distributions in the versions that were tested together."""
    venv.create(folder, with_pip=True)
    constraints = str(ROOT / "constraints.txt")
    words: Sequence[str] = (str(folder / "bin" / "pip"), "install", "-q", "--disable-pip-version-check")
    # What builds an sdist is held to the list by the environment: `-c` does not reach it.
    held = {**os.environ, "PIP_BUILD_CONSTRAINT": constraints, "PIP_CONSTRAINT": constraints}
    subprocess.run([*words, "-c", constraints, *requirements], cwd=folder, env=held, check=True)
    return folder


def _try(archive: Path, folder: Path) -> None:
    print(f"{archive.name}: the tutorial", flush=True)
    folder.mkdir()
    environment = _environment(folder / "environment", f"openrois[demo] @ {archive.as_uri()}", *_TEST_TOOLS)
    (folder / "tutorial").mkdir()
    run_tutorial(environment, ROOT / "docs" / "examples", folder / "tutorial")


if __name__ == "__main__":
    raise SystemExit(main())
