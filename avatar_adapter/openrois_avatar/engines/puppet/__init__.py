"""The avatar as a flat drawing, made with pygame-ce: `python -m openrois_avatar.engines.puppet`.

It opens no window and needs no library of the system.
"""

import importlib.util


def available() -> tuple[bool, str]:
    """Return whether this engine runs here, and if not, what to install."""
    if importlib.util.find_spec("pygame") is None:
        return False, "pygame-ce is not installed: pip install 'openrois[puppet]'"
    return True, ""
