"""`python -m tools.sculpt`: write the baked figures, or with `--check` say which are out of date."""

import argparse
import sys
from pathlib import Path

from openrois_avatar.engines.figure.baked import FOLDER, BakedError, path_of, read

from tools.sculpt.bake import baked, differences
from tools.sculpt.figures import FIGURES

__all__ = ["main"]


def main(arguments: list[str] | None = None, folder: Path = FOLDER) -> int:
    """Write or check every figure's file; return what the process exits with."""
    parser = argparse.ArgumentParser("tools.sculpt", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; fail where a file is out of date")
    checking = parser.parse_args(arguments).check
    stale = False
    for name, sculpt in FIGURES.items():
        pieces = sculpt()
        try:
            found = differences(read(name, folder), pieces)
        except BakedError as error:
            found = [str(error)]
        if not found:
            continue
        stale = True
        path = path_of(name, folder)
        if checking:
            sys.stderr.writelines(f"{path.name} is out of date: {line}\n" for line in found)
        else:
            path.write_bytes(baked(pieces))
            sys.stdout.write(f"{path.name}\n")
    return 1 if checking and stale else 0


if __name__ == "__main__":
    sys.exit(main())
