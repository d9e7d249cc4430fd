"""Runs a module as a child that does not survive its parent.

`python -m openrois_body.processes.launch PARENT MODULE [ARGS]` is the command line of the child.

This is done in the child, after its start, because code between fork and exec is not safe in a process with threads.
"""

import ctypes
import os
import runpy
import signal
import sys
from typing import Final

_PR_SET_PDEATHSIG: Final = 1


def command_line(module: str, *arguments: str) -> list[str]:
    """Return the command line that runs a module as such a child of this process."""
    # A file in the working directory may be named like a module.
    return [sys.executable, "-P", "-m", "openrois_body.processes.launch", str(os.getpid()), module, *arguments]


def main(arguments: list[str]) -> None:
    """Run a module as `__main__`, to be killed by the kernel when the process `PARENT` ends, however it ends.

    On systems other than Linux nothing ties the two together; a child there ends when its pipe or socket does.
    """
    parent, module, *rest = arguments
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != int(parent):
            raise SystemExit("the parent has ended already")
    sys.argv = [module, *rest]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])
