"""The avatar as a sculpted figure, drawn by Panda3D's software renderer.

`python -m openrois_avatar.engines.panda3d` runs it on the engine link.
"""

import ctypes
import importlib.util
import sys

_LIBRARY = "libX11.so.6"


def available() -> tuple[bool, str]:
    """Return whether this engine runs here, and if not, what to install. Opens no window."""
    if importlib.util.find_spec("panda3d") is None:
        return False, "Panda3D is not installed: pip install 'openrois[panda3d]'"
    if sys.platform == "linux":
        try:
            ctypes.CDLL(_LIBRARY)
        except OSError:
            return False, f"Panda3D needs the system library {_LIBRARY}: apt install libx11-6"
    return True, ""
