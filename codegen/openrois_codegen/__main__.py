"""`python -m openrois_codegen`: write what is generated, or with `--check` say what is out of date."""

import argparse
import sys
from pathlib import Path
from typing import Final

from openrois_codegen.targets import GENERATED, targets

__all__ = ["main"]

_ROOT: Final = Path(__file__).parents[2]


def main(arguments: list[str] | None = None, root: Path = _ROOT) -> int:
    """Write or check every generated file; return the exit status of the process."""
    parser = argparse.ArgumentParser("openrois_codegen", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail where a file is out of date")
    checking = parser.parse_args(arguments).check
    generated = targets(root)
    stale = [path for path, text in generated.items() if _read(root / path) != text]
    stale += [path for path in _present(root) if path not in generated]
    if checking:
        sys.stderr.writelines(f"{path} is out of date: run `make generate`\n" for path in stale)
        return 1 if stale else 0
    for path in stale:
        if path in generated:
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(generated[path], encoding="utf-8")
        else:
            (root / path).unlink()
        sys.stdout.write(f"{path}\n")
    return 0


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def _present(root: Path) -> list[str]:
    """Return the generated files that are there, wanted or not."""
    found = (path for pattern in GENERATED for path in sorted(root.glob(pattern)) if path.is_file())
    return [str(path.relative_to(root)) for path in found]


if __name__ == "__main__":
    sys.exit(main())
