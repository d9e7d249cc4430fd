"""The renderer: the rooms in Panda3D, drawn in software into memory, without a display."""

from math import atan, degrees, sin, tan
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.messages import Place
from openrois_body.vision.box import FIELD_OF_VIEW
from panda3d.core import (
    Camera,
    FrameBufferProperties,
    GraphicsEngine,
    GraphicsOutput,
    GraphicsPipe,
    GraphicsPipeSelection,
    NodePath,
    PerspectiveLens,
    Texture,
    WindowProperties,
    load_prc_file_data,
)

from openrois_robots.simulated.drawing import furnishing, textures
from openrois_robots.simulated.drawing.nodes import add_mesh, make_texture
from openrois_robots.simulated.drawing.view import View
from openrois_robots.simulated.world.plan import Person, Plan

__all__ = ["CAMERA_HEIGHT", "Renderer"]

CAMERA_HEIGHT: Final = 1.5
"""Metres of the camera above the floor: the robot has a mast, for it looks people in the face."""
_NEAR, _FAR = 0.12, 14.0
_SKY: Final = (0.75, 0.76, 0.78, 1)
_STRIDE: Final = 0.35
"""Metres of a step of the walking visitor, and by how many degrees its legs swing."""
_SWING: Final = 24.0

load_prc_file_data(
    "",
    "load-display p3tinydisplay\nwindow-type offscreen\nsync-video 0\naudio-library-name null\n"
    "notify-level-display error\nnotify-level-x11display fatal\n",
)


class Renderer:
    """Draws the rooms as a camera sees them; used by one thread at a time.

    Args:
        plan: of the rooms.
        width: of the pictures, in pixels.
        height: of the pictures.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, plan: Plan, width: int, height: int) -> None:
        self._width, self._height = width, height
        self._root = NodePath("rooms")
        self._engine = GraphicsEngine.get_global_ptr()
        self._texture = Texture()
        self._buffer = _opened(self._engine, width, height)
        self._buffer.add_render_texture(self._texture, GraphicsOutput.RTM_copy_ram)
        self._buffer.set_clear_color(_SKY)
        lens = PerspectiveLens()
        lens.set_near_far(_NEAR, _FAR)
        across = tan(FIELD_OF_VIEW / 2)
        lens.set_fov(degrees(FIELD_OF_VIEW), degrees(2 * atan(across * height / width)))
        self._camera: NodePath = self._root.attach_new_node(Camera("camera", lens))
        self._buffer.make_display_region().set_camera(self._camera)
        self._furnish(plan)
        self._visitor, self._legs = self._stand(plan.visitor)
        self._visitor.hide()

    def draw(self, view: View) -> NDArray[np.uint8]:
        """Return the picture as BGRA, (height, width, 4), top row first; an array of its own."""
        at = view.camera
        self._camera.set_pos_hpr(at.x, at.y, CAMERA_HEIGHT, degrees(at.th) - 90, degrees(view.tilt), 0)
        self._place_visitor(view.visitor, view.step)
        self._engine.render_frame()
        rows = np.frombuffer(self._texture.get_ram_image(), np.uint8).reshape(self._height, self._width, 4)
        # Panda3D's rows run from the bottom up, and its next picture overwrites them.
        return rows[::-1].copy()

    def close(self) -> None:
        """Release the buffer."""
        self._engine.remove_window(self._buffer)
        self._root.remove_node()

    def _furnish(self, plan: Plan) -> None:
        boards, tiles = (make_texture(each, repeats=True) for each in (textures.boards(), textures.tiles()))
        for room in plan.rooms:
            floor = add_mesh("floor", self._root, furnishing.floor_mesh(room))
            floor.set_texture(boards if room.boards else tiles)
        add_mesh("walls", self._root, furnishing.walls_mesh(plan))
        for window in plan.windows:
            add_mesh("window", self._root, furnishing.window_mesh(window))
        add_mesh("mat", self._root, furnishing.mat_mesh(plan.mat))
        for piece in plan.furniture:
            add_mesh(piece.name, self._root, furnishing.furniture_mesh(piece))
        for person in plan.persons:
            self._stand(person)

    def _stand(self, person: Person) -> tuple[NodePath, tuple[NodePath, NodePath]]:
        """Add a person, and return its node and those of its legs."""
        node = self._root.attach_new_node(person.name)
        add_mesh("body", node, furnishing.person_body(person))
        head = add_mesh("head", node, furnishing.person_head())
        head.set_texture(make_texture(textures.face(person.skin, person.hair)))
        left, right = (add_mesh("leg", node, furnishing.person_leg(person, side)) for side in (1, -1))
        for leg in (left, right):
            leg.set_z(furnishing.HIPS)
        node.set_pos_hpr(person.place.x, person.place.y, 0, degrees(person.place.th), 0, 0)
        return node, (left, right)

    def _place_visitor(self, place: Place | None, step: float) -> None:
        if place is None:
            return
        self._visitor.show()
        self._visitor.set_pos_hpr(place.x, place.y, 0, degrees(place.th), 0, 0)
        for leg, side in zip(self._legs, (1, -1), strict=True):
            leg.set_r(side * _SWING * sin(step / _STRIDE * np.pi))


def _opened(engine: GraphicsEngine, width: int, height: int) -> GraphicsOutput:
    pipe = GraphicsPipeSelection.get_global_ptr().make_default_pipe()
    if pipe is None:
        raise RuntimeError("Panda3D has no graphics pipe here")
    properties = FrameBufferProperties()
    properties.set_rgba_bits(8, 8, 8, 8)
    properties.set_depth_bits(16)
    size = WindowProperties.size(width, height)
    buffer = engine.make_output(pipe, "camera", 0, properties, size, GraphicsPipe.BF_refuse_window)
    if buffer is None:
        raise RuntimeError("Panda3D cannot open an off-screen buffer here")
    return buffer
