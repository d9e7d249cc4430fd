"""The stage: figure and room are drawn at twice the size, what is farther away first, and made smaller."""

from math import log2
from typing import Final

import cv2
import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.puppet import arms, legs, room, visitor
from openrois_avatar.engines.puppet.body import Body
from openrois_avatar.engines.puppet.canvas import Canvas, shared
from openrois_avatar.engines.puppet.face import Face, draw_ear
from openrois_avatar.engines.puppet.hair import Hair
from openrois_avatar.engines.puppet.view import Lens, View
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.shot import HOME_SHOT, METRE
from openrois_avatar.engines.settings import Picture, Pixels

_OVERSAMPLING: Final = 2
"""The drawing is so many times larger than the picture, which smooths its edges."""
_SIZES: Final = 6
"""Sizes that soft spots are prepared in, for each time that the figure is half as large."""


class Stage:
    """Draws the figure and its room."""

    def __init__(self, picture: Picture) -> None:
        cv2.setNumThreads(1)
        self._hair = Hair()
        self.resize(picture)

    def resize(self, picture: Picture) -> None:
        """Draw pictures of another size from now on."""
        self._size = (picture.width, picture.height)
        self._home = Lens(picture.width * _OVERSAMPLING, picture.height * _OVERSAMPLING)
        self._wall = room.Wall(self._home)
        self._large = self._wall.close.copy()
        self._small = np.empty((picture.height, picture.width, 4), np.uint8)
        self._canvas = Canvas(shared(self._large))
        self._prepared: dict[int, tuple[Body, Face]] = {}

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """The figure in this pose as BGRA, (height, width, 4), top row first; the next call uses the same array."""
        lens, canvas = Lens(self._home.width, self._home.height, scene.shot), self._canvas
        items: list[room.Drawn] = [
            (scene.place.y * METRE, lambda canvas, lens: self._draw_figure(canvas, lens, pose, scene))
        ]
        if scene.shot == HOME_SHOT:
            np.copyto(self._large, self._wall.close)
        else:
            self._wall.draw(self._large, lens)
            items += room.furniture(lens)
        people = [scene.place]
        if (other := scene.visitor) is not None and scene.shot.sees(other.place, lens.width / lens.height):
            items.append((other.place.y * METRE, lambda canvas, lens: visitor.draw(canvas, lens, other)))
            people.append(other.place)
        if not scene.shot.is_close:
            room.draw_floor(canvas, lens)
            for place in people:
                room.draw_shadow(canvas, lens, place)
        for _, draw in sorted(items, key=lambda item: -item[0]):
            draw(canvas, lens)
        cv2.resize(self._large, self._size, dst=self._small, interpolation=cv2.INTER_AREA)
        return self._small

    def _draw_figure(self, canvas: Canvas, lens: Lens, pose: Pose, scene: Scene) -> None:
        view, whole = View.of(pose, lens, scene.place), not scene.shot.is_close
        body, face = self._sized(view.round.pixels(1.0))
        if whole:
            legs.draw(canvas, view, palette.TROUSERS, palette.SHOES)
        if view.from_behind:
            arms.draw_lower(canvas, view, pose, whole)
            arms.draw_upper(canvas, view, pose)
            body.draw(canvas, view, pose, whole)
            self._hair.draw_back(canvas, view)
            return
        self._hair.draw_behind(canvas, view)
        arms.draw_upper(canvas, view, pose)
        body.draw(canvas, view, pose, whole)
        face.draw(canvas, view, pose)
        self._hair.draw_before(canvas, view)
        draw_ear(canvas, view, -1, pose.head_yaw)
        arms.draw_lower(canvas, view, pose, whole)

    def _sized(self, unit: float) -> tuple[Body, Face]:
        """Body and face with their spots for about so many pixels per decimetre."""
        number = round(_SIZES * log2(unit / self._home.scale))
        if number not in self._prepared:
            scale = self._home.scale * 2 ** (number / _SIZES)
            self._prepared[number] = Body(scale), Face(scale)
        return self._prepared[number]
