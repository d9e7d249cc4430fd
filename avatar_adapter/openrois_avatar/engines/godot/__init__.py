"""The avatar as a Godot 3 project, drawn on this machine's display or on a virtual one."""

import os
import shutil
from pathlib import Path
from typing import Final

from openrois_avatar.engines.godot.screen import SERVER

__all__ = ["available", "program", "project"]

_PROGRAMS: Final = ("godot3-runner", "godot3")
"""Programs that run a Godot 3 project, the smallest first."""


def available() -> tuple[bool, str]:
    """Return whether the engine runs on this machine, and if not, a sentence that says what to install."""
    if program() is None:
        return False, f"Godot 3 is not found ({' or '.join(_PROGRAMS)}); run `apt install godot3-runner`"
    if "DISPLAY" not in os.environ and shutil.which(SERVER) is None:
        return False, f"Godot needs a display, but DISPLAY is not set and {SERVER} is not found; run `apt install xvfb`"
    return True, ""


def program() -> str | None:
    """Return the path of the program that runs Godot projects, None if there is none."""
    return next((path for name in _PROGRAMS if (path := shutil.which(name))), None)


def project() -> Path:
    """Return the folder of the Godot project: package data of a wheel, or `avatar_adapter/godot` in a checkout."""
    here = Path(__file__)
    installed = here.with_name("project")
    return installed if installed.is_dir() else here.parents[3] / "godot"
