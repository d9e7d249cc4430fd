"""Runs the Panda3D engine on the engine link."""

import sys

from openrois_avatar.engines.figure.baked import BakedError
from openrois_avatar.engines.panda3d import available
from openrois_avatar.engines.room.shot import VIEWPOINTS
from openrois_avatar.engines.runner import main
from openrois_avatar.engines.settings import Picture, Renderer


def _renderer(picture: Picture) -> Renderer:
    from openrois_avatar.engines.panda3d.stage import Stage  # needs Panda3D: imported once it is known to be there

    return Stage(picture)


if __name__ == "__main__":
    try:
        sys.exit(main("panda3d", available, _renderer, VIEWPOINTS, sys.argv[1:]))
    except BakedError as error:
        sys.exit(str(error))
