"""The figure at rest: its head is drawn for every picture, its body once it has moved visibly."""

from collections.abc import Mapping, Sequence
from typing import Final

from panda3d.core import NodePath

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure import figure
from openrois_avatar.engines.figure.part import Part
from openrois_avatar.engines.figure.rig import Frame, Space
from openrois_avatar.engines.panda3d import sight
from openrois_avatar.engines.panda3d.figure import Figure
from openrois_avatar.engines.panda3d.view import Backdrop, Screen, View, middle
from openrois_avatar.engines.room.shot import HOME_SHOT
from openrois_avatar.engines.settings import Picture, Pixels

_CHIN: Final = 0.60
"""The level below everything of the head of a figure at rest, in heights of the picture from its top."""
_CROWN: Final = 0.04
"""The level above it."""
_HEAD_WIDTH, _BODY_WIDTH = 0.54, 0.72
"""Width of the moving part above the former level, and below it, in heights of the picture."""
# What moves something of the body by about 0.001 dm in the picture: a sixth of a pixel where that is 720 high.
_HEIGHT: Final = 720
_SWAY: Final = 0.0002
_TURN: Final = 0.003
_BREATH: Final = 0.025
_SHRUG: Final = 0.0025
_REACH: Final = 0.0015

_Stance = tuple[float, ...]


class Resting:
    """Draws a figure that stands at its first place, and moves no more than `sight.AT_REST`."""

    def __init__(self, parts: Sequence[Part], picture: Picture, screen: Screen) -> None:
        self._screen = screen
        self._heads, self._bodies = NodePath("head at rest"), NodePath("body at rest")
        self._open_views(picture)
        body = [part for part in parts if part.space == "body"]
        self._head = Figure("head", _front(parts, self._heads, self._head_view, screen), self._heads)
        """The head, with the visible part of the body beside it."""
        self._body = Figure("body", _front(body, self._bodies, self._body_view, screen), self._bodies)
        self._backdrops: dict[View, Backdrop] = {}
        self._drawn: _Stance | None = None
        """The body's stance when it was drawn last; None where it is not in the picture."""

    def resize(self, picture: Picture) -> None:
        """Draw into pictures of another size from now on; `set_room` has to follow."""
        self._screen.close(self._head_view, self._body_view)
        self._open_views(picture)

    def _open_views(self, picture: Picture) -> None:
        self._seen = _HEIGHT / picture.height
        """The steps of a stance that make a sixth of a pixel."""
        self._head_view = View(self._heads, picture, middle(picture, _HEAD_WIDTH, _CROWN, _CHIN))
        self._body_view = View(self._bodies, picture, middle(picture, _BODY_WIDTH, _CHIN))

    def set_room(self, room: Pixels) -> None:
        """Set the background: a picture without the figure."""
        self._backdrops = {view: Backdrop(room, view.area) for view in (self._head_view, self._body_view)}
        self._drawn = None

    def picture_changed(self) -> None:
        """Note that something else has been drawn into the picture."""
        self._drawn = None

    def draw(self, pose: Pose, frames: Mapping[Space, Frame], relight: float, picture: Pixels) -> None:
        """Draw the figure into a picture that has only its earlier drawing."""
        visible = figure.visible(pose)
        stance = _stance(pose)
        views = [self._head_view]
        self._head.update(pose, frames, visible, relight)
        if self._drawn is None or _moved(self._drawn, stance) > self._seen:
            self._body.update(pose, frames, visible, relight)
            self._drawn = stance
            views.append(self._body_view)
        self._screen.draw(HOME_SHOT, *views)
        for view in views:
            self._backdrops[view].lay_under(view.read(), picture)


def _front(parts: Sequence[Part], scene: NodePath, view: View, screen: Screen) -> list[Part]:
    """Return the visible faces of some parts."""

    def draw() -> Pixels:
        screen.draw(HOME_SHOT, view)
        return view.read_large()

    return sight.front(parts, sight.AT_REST, scene, draw)


def _stance(pose: Pose) -> _Stance:
    """Return the body's stance, in steps of about 0.001 dm in the picture."""
    turns = pose.head_yaw / _TURN, pose.head_pitch / _TURN, pose.head_roll / _TURN
    sways = pose.twist / _SWAY, pose.side / _SWAY, pose.lean / _SWAY
    shrugs = pose.shoulder_left / _SHRUG, pose.shoulder_right / _SHRUG
    arms = (value / _REACH for arm in (pose.left, pose.right) for value in (arm.out, arm.y, arm.z, arm.swivel))
    return *turns, *sways, *shrugs, pose.breath / _BREATH, *arms


def _moved(before: _Stance, now: _Stance) -> float:
    """Return by how many steps the body has moved."""
    return max([abs(one - other) for one, other in zip(before, now, strict=True)])
