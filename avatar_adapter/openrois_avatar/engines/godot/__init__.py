"""The avatar as a Godot 3 project, drawn on this machine's display or on a virtual one."""

import os
import shutil
from pathlib import Path
from typing import Final

from openrois_avatar.engines.godot.screen import SERVER

__all__ = ["available", "program", "project"]

_PROGRAMS: Final = ("godot3-runner", "godot3")
"""What runs a Godot 3 project, the smallest first."""


def available() -> tuple[bool, str]:
    """Whether the engine runs on this machine, and if not, a sentence that says what to install."""
    if program() is None:
        return False, f"Godot 3 is not found ({' or '.join(_PROGRAMS)}): apt install godot3-runner"
    if "DISPLAY" not in os.environ and shutil.which(SERVER) is None:
        return False, f"Godot needs a display, and neither DISPLAY is set nor {SERVER} found: apt install xvfb"
    return True, ""


def program() -> str | None:
    """The path of the program that runs Godot projects, None if there is none."""
    return next((path for name in _PROGRAMS if (path := shutil.which(name))), None)


def project() -> Path:
    """The folder of the Godot project: package data in an installed wheel, `avatar_adapter/godot` in a checkout."""
    here = Path(__file__)
    installed = here.with_name("project")
    return installed if installed.is_dir() else here.parents[3] / "godot"
