"""Becomes another program: `python -m openrois_bench.processes.program PATH [ARGUMENTS]`.

So a program that knows nothing of its parent is tied to it like the children that are Python.
"""

import os
import sys

if __name__ == "__main__":
    os.execv(sys.argv[1], sys.argv[1:])  # noqa: S606 - the path is the caller's own
