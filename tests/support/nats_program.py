"""Where the program of a NATS server is."""

import shutil
import sys
from pathlib import Path

from tests.support.packages import ROOT

__all__ = ["nats_program"]


def nats_program() -> Path | None:
    """Return the server's program: that of this environment, of the checkout's, or of the system."""
    beside = [folder / "nats-server" for folder in (Path(sys.executable).parent, ROOT / ".venv/bin")]
    system = shutil.which("nats-server")
    return next((path for path in beside if path.exists()), Path(system) if system else None)
