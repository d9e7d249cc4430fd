"""Becomes a Godot game on the engine link: `python -m openrois_avatar.engines.godot [PROJECT]`, else the demo."""

import os
import sys
from collections.abc import Sequence

from openrois_avatar.engines.godot import available, program, project
from openrois_avatar.engines.godot.screen import NoScreen, virtual_screen

_SIZE = (640, 360)
"""Pixels of the window: of the pictures, too."""


def main(arguments: Sequence[str]) -> None:
    """Replace this process by Godot, so that a signal to the one is a signal to the other.

    Args:
        arguments: the folder of a project, or nothing for the demo.

    Raises:
        SystemExit: Godot does not run here; the text says what to install.
    """
    works, hint = available()
    runner = program()
    if not works or runner is None:
        raise SystemExit(hint)
    environment = {**os.environ, "LANG": "en"}  # Godot warns about a locale C
    if "DISPLAY" not in environment:
        try:
            environment.update(virtual_screen(*_SIZE))
        except NoScreen as error:
            raise SystemExit(str(error)) from error
    # Sound goes over the link: Godot itself needs no sound card.
    game = arguments[0] if arguments else str(project())
    os.execve(runner, [runner, "--path", game, "--audio-driver", "Dummy"], environment)  # noqa: S606 - a program of this machine


if __name__ == "__main__":
    main(sys.argv[1:])
