"""Becomes the Godot engine on the engine link: `python -m openrois_avatar.engines.godot`."""

import os

from openrois_avatar.engines.godot import available, program, project
from openrois_avatar.engines.godot.screen import NoScreen, virtual_screen

_SIZE = (640, 360)
"""Pixels of the window: of the pictures, too."""


def main() -> None:
    """Take the place of this process with Godot: a signal to the one is a signal to the other.

    Raises:
        SystemExit: it does not run here; the text says what to install.
    """
    works, hint = available()
    runner = program()
    if not works or runner is None:
        raise SystemExit(hint)
    environment = dict(os.environ)
    if "DISPLAY" not in environment:
        try:
            environment.update(virtual_screen(*_SIZE))
        except NoScreen as error:
            raise SystemExit(str(error)) from error
    # What is heard goes over the link: Godot itself needs no sound card.
    arguments = [runner, "--path", str(project()), "--audio-driver", "Dummy", "--language", "en"]
    os.execve(runner, arguments, environment)  # noqa: S606 - a program of this machine


if __name__ == "__main__":
    main()
