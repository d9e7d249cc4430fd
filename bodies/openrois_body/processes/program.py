"""Becomes another program. Run by `openrois_body.processes.launch`, which ties it to its parent before."""

import os
import sys

if __name__ == "__main__":
    os.execv(sys.argv[1], sys.argv[1:])  # noqa: S606 - the program was chosen by the user of this machine
