"""What the runner and the renderers agree on."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.room.scene import AT_HOME, Scene

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Picture:
    """Size in pixels, both even, and pictures per second."""

    width: int = 640
    height: int = 360
    fps: int = 30


class Renderer(Protocol):
    """Draws poses in scenes."""

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """The avatar in this pose as BGRA, (height, width, 4), top row first; the next call may reuse the array."""


Available = Callable[[], tuple[bool, str]]
Factory = Callable[[Picture], Renderer]
