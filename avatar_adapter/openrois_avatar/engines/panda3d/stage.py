"""The stage: the figure and its room as a scene of Panda3D, drawn pose by pose."""

from dataclasses import replace
from typing import Final

import cv2
import numpy as np
from panda3d.core import GraphicsEngine, NodePath

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.panda3d import sight
from openrois_avatar.engines.panda3d.backdrop import Backdrop
from openrois_avatar.engines.panda3d.figure import Figure
from openrois_avatar.engines.panda3d.room import Room
from openrois_avatar.engines.panda3d.view import View
from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.shot import HOME_SHOT, METRE, Shot
from openrois_avatar.engines.sculpt import figure
from openrois_avatar.engines.sculpt.rig import standing
from openrois_avatar.engines.settings import Picture, Pixels

_RELIGHT: Final = 0.006
_RELIGHT_FAR: Final = 0.05
"""A part is lit anew once it has turned by about so many radians, seen closely and from farther away."""
_EXTENTS: Final = (sight.AT_REST, sight.ATTENTIVE)
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
        self._engine = GraphicsEngine.get_global_ptr()
        self._scene = scene = NodePath("stage")
        self._open_views(picture)
        parts = figure.build()
        # All of them first: nothing else may be in the scene meanwhile.
        fronts = [sight.front(parts, extent, scene, self._drawn_large) for extent in _EXTENTS]
        self._fronts = [Figure("front", kept, scene) for kept in fronts]
        """What can be seen of the figure from the front, for each extent."""
        self._whole = Figure("whole", parts, scene)
        self._figures = [*self._fronts, self._whole]
        self._room = Room(scene)
        self._draw_backdrops(picture)

    def resize(self, picture: Picture) -> None:
        """Draw pictures of another size from now on, which is not above that of the first."""
        for view in self._views:
            view.close()
        self._open_views(picture)
        self._draw_backdrops(picture)

    def _open_views(self, picture: Picture) -> None:
        self._wide = View(self._scene, picture.width, picture.height)
        self._narrow, self._slim = (
            View(self._scene, min(picture.width, 2 * round(picture.height * width / 2)), picture.height)
            for width in (_NARROW, _SLIM)
        )
        self._pixels = np.empty((picture.height, picture.width, 4), np.uint8)
        self._last: View | None = None
        """What has drawn over the backdrop last; beside it the picture shows nothing else."""
        self._aspect = picture.width / picture.height

    def _draw_backdrops(self, picture: Picture) -> None:
        self._room.show(True)
        self._room.update(AT_HOME)
        self._only(None)
        room = self._drawn(self._wide, HOME_SHOT)
        self._backdrops = {view: Backdrop(room, view.middle(picture.width)) for view in self._views}

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """The figure in this pose as BGRA, (height, width, 4), top row first; the next call reuses the array."""
        place, shot = scene.place, scene.shot
        company = scene.visitor is not None and shot.sees(scene.visitor.place, self._aspect)
        at_home = shot == HOME_SHOT and not company
        visible = figure.visible(pose, whole=not shot.is_close)
        hands = visible["hand_left"] or visible["hand_right"]
        front = self._seen(pose) if at_home and not hands and place == HOME else None
        shown = front or self._whole
        # Through its own eyes it does not see itself.
        self._only(None if shot.own else shown)
        world = standing(place.x * METRE, place.y * METRE, place.th)
        frames = figure.frames(pose, world, [space for space, seen in visible.items() if seen])
        shown.update(pose, frames, visible, _RELIGHT if shot.is_close else _RELIGHT_FAR)
        self._room.show(not at_home)
        if at_home:
            self._draw_at_home(self._wide if hands else self._narrow if front is None else self._slim)
        else:
            self._room.update(scene if company else replace(scene, visitor=None))
            self._last = None
            np.copyto(self._pixels, self._drawn(self._wide, shot))
        return self._pixels

    @property
    def _views(self) -> tuple[View, ...]:
        return self._slim, self._narrow, self._wide

    def _seen(self, pose: Pose) -> Figure | None:
        """The least of the figure that has all that is seen of it from the front; None if that is not known."""
        within = (front for extent, front in zip(_EXTENTS, self._fronts, strict=True) if extent.holds(pose))
        return next(within, None)

    def _only(self, shown: Figure | None) -> None:
        for each in self._figures:
            each.show(each is shown)

    def _render(self, view: View, shot: Shot) -> None:
        for each in self._views:
            each.turn(each is view)
        view.aim(shot)
        self._engine.render_frame()

    def _drawn(self, view: View, shot: Shot) -> Pixels:
        """What the scene shows; another picture reuses the array."""
        self._render(view, shot)
        return view.read()

    def _drawn_large(self) -> Pixels:
        """What the scene shows from the front, as large as it is drawn."""
        self._render(self._narrow, HOME_SHOT)
        return self._narrow.read_large()

    def _draw_at_home(self, view: View) -> None:
        """Draw the figure over a backdrop that was drawn before; where only its middle changes, only that."""
        if view is not self._last:
            self._backdrops[self._wide].fill(self._pixels)
        self._last = view
        self._backdrops[view].lay_under(self._drawn(view, HOME_SHOT), self._pixels)
