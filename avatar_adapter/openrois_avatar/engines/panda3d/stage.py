"""The stage: the figure and its room as a scene of Panda3D, drawn pose by pose."""

from dataclasses import replace
from typing import Final

import cv2
import numpy as np
from panda3d.core import NodePath

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure import figure
from openrois_avatar.engines.figure.rig import standing
from openrois_avatar.engines.panda3d import sight
from openrois_avatar.engines.panda3d.figure import Figure
from openrois_avatar.engines.panda3d.resting import Resting
from openrois_avatar.engines.panda3d.room import Room
from openrois_avatar.engines.panda3d.view import Backdrop, Screen, View, middle
from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.shot import HOME_SHOT, METRE, Shot
from openrois_avatar.engines.settings import Picture, Pixels

_RELIGHT: Final = 0.006
_RELIGHT_FAR: Final = 0.05
"""A part is lit again once it has turned by about so many radians, in the close view and in others."""
_SLIM, _NARROW = 0.78, 0.90
"""Width, in heights of the picture, of what the figure fills within these extents, and with its hands down."""


class Stage:
    """Draws the figure; one per process.

    Where the figure begins, only the figure is drawn anew; and while it does nothing but look and speak, only what can
    be seen of it then, and only in the middle of the picture.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, picture: Picture) -> None:
        cv2.setNumThreads(1)
        self._screen = Screen()
        self._scene = scene = NodePath("stage")
        self._open_views(picture)
        parts = figure.build()
        self._resting = Resting(parts, picture, self._screen)
        # Before everything else: nothing else may be in the scene meanwhile.
        attentive = sight.front(parts, sight.ATTENTIVE, scene, self._drawn_large)
        self._front, self._whole = Figure("front", attentive, scene), Figure("whole", parts, scene)
        self._room = Room(scene)
        self._draw_backdrops()

    def resize(self, picture: Picture) -> None:
        """Draw pictures of another size from now on, which is not larger than the first one."""
        self._screen.close(self._wide, self._narrow, self._slim)
        self._open_views(picture)
        self._resting.resize(picture)
        self._draw_backdrops()

    def _open_views(self, picture: Picture) -> None:
        self._aspect = picture.width / picture.height
        self._wide, self._narrow, self._slim = (
            View(self._scene, picture, middle(picture, width)) for width in (self._aspect, _NARROW, _SLIM)
        )
        self._pixels = np.empty((picture.height, picture.width, 4), np.uint8)
        self._last: View | Resting | None = None
        """The last drawing over the backdrop; the picture shows nothing else beside it."""

    def _draw_backdrops(self) -> None:
        self._room.show(True)
        self._room.update(AT_HOME)
        self._only(None)
        room = self._drawn(self._wide, HOME_SHOT)
        self._backdrops = {view: Backdrop(room, view.area) for view in (self._wide, self._narrow, self._slim)}
        self._resting.set_room(room)

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """Return the figure in this pose as BGRA, (height, width, 4), top row first; the next call reuses the array."""
        place, shot = scene.place, scene.shot
        company = scene.visitor is not None and shot.sees(scene.visitor.place, self._aspect)
        at_home = shot == HOME_SHOT and not company
        visible = figure.visible(pose, whole=not shot.is_close)
        hands = visible["hand_left"] or visible["hand_right"]
        world = standing(place.x * METRE, place.y * METRE, place.th)
        frames = figure.frames(pose, world, [space for space, seen in visible.items() if seen])
        relight = _RELIGHT if shot.is_close else _RELIGHT_FAR
        facing = at_home and not hands and place == HOME
        if facing and sight.AT_REST.holds(pose):
            self._begin(self._resting)
            self._resting.draw(pose, frames, relight, self._pixels)
            return self._pixels
        attentive = facing and sight.ATTENTIVE.holds(pose)
        shown = self._front if attentive else self._whole
        # Through its own eyes it does not see itself.
        self._only(None if shot.own else shown)
        shown.update(pose, frames, visible, relight)
        self._room.show(not at_home)
        if at_home:
            self._draw_at_home(self._wide if hands else self._slim if attentive else self._narrow)
        else:
            self._room.update(scene if company else replace(scene, visitor=None))
            self._last = None
            np.copyto(self._pixels, self._drawn(self._wide, shot))
        return self._pixels

    def _only(self, shown: Figure | None) -> None:
        for each in (self._front, self._whole):
            each.show(each is shown)

    def _drawn(self, view: View, shot: Shot) -> Pixels:
        """Return the picture of the scene; the next one reuses the array."""
        self._screen.draw(shot, view)
        return view.read()

    def _drawn_large(self) -> Pixels:
        """Return the picture of the scene from the front, in the size of the drawing."""
        self._screen.draw(HOME_SHOT, self._narrow)
        return self._narrow.read_large()

    def _draw_at_home(self, view: View) -> None:
        """Draw the figure over a backdrop that was drawn before; where only its middle changes, only that."""
        self._begin(view)
        self._backdrops[view].lay_under(self._drawn(view, HOME_SHOT), self._pixels)

    def _begin(self, drawing: "View | Resting") -> None:
        """Remove other drawings from the picture."""
        if drawing is not self._last:
            self._backdrops[self._wide].fill(self._pixels)
            self._resting.picture_changed()
        self._last = drawing
