"""The interface between the runner and the renderers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.room.scene import AT_HOME, Scene

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Picture:
    """The size of pictures in pixels, both even, and their rate."""

    width: int = 640
    height: int = 360
    fps: int = 30


LARGE: Final = (1280, 720)
SMALL: Final = (640, 360)
"""Width and height that an engine chooses from without `--size`."""


class Renderer(Protocol):
    """Draws poses in scenes."""

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """Return the figure in this pose as BGRA, (height, width, 4), top row first; the next call may reuse it."""

    def resize(self, picture: Picture) -> None:
        """Draw pictures of another size from now on, which is not larger than the first one."""


Available = Callable[[], tuple[bool, str]]
Factory = Callable[[Picture], Renderer]
