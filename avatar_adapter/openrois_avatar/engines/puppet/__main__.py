"""Runs the puppet engine on the engine link."""

import os
import sys

from openrois_avatar.engines.puppet import available
from openrois_avatar.engines.room.shot import VIEWPOINTS
from openrois_avatar.engines.runner import main
from openrois_avatar.engines.settings import Picture, Renderer


def _renderer(picture: Picture) -> Renderer:
    os.environ["SDL_VIDEODRIVER"] = "dummy"
    os.environ["PYGAME_HIDE_SUPPORT_PROMPT"] = "1"
    from openrois_avatar.engines.puppet.stage import Stage  # needs pygame: imported once it is known to be there

    return Stage(picture)


if __name__ == "__main__":
    sys.exit(main("puppet", available, _renderer, VIEWPOINTS[:-1], sys.argv[1:]))
