"""The physics: a round body that is pushed with a velocity, among walls and obstacles. Bullet, as Panda3D has it."""

from math import hypot
from typing import Final

from openrois_body.messages import Place
from panda3d.bullet import BulletBoxShape, BulletCylinderShape, BulletRigidBodyNode, BulletWorld, ZUp
from panda3d.core import BitMask32, NodePath, Point3, TransformState, Vec3

from openrois_robots.simulated.world.plan import PERSON_RADIUS, Plan

__all__ = ["RADIUS", "STEP", "Physics"]

STEP: Final = 1 / 60
"""Seconds of each step."""
RADIUS: Final = 0.22
"""Metres: of the robot's body; its planner keeps a little more."""
_TALL: Final = 1.3
_MASS: Final = 30.0
_THICK: Final = 0.5
"""Half of the thickness of the walls around everything, in metres."""
_HAIR: Final = 0.01
"""Metres by which the body that looks ahead is slimmer, so that a wall beside it is not ahead of it."""
_ALL, _OTHERS = BitMask32.bit(0), BitMask32.bit(1)
"""Groups: everything meets in the first; the robot itself is not in the second, in which it looks ahead."""


class Physics:
    """The robot's body in its rooms. The body does not turn over, and has no wheels.

    Args:
        plan: of the rooms.
    """

    def __init__(self, plan: Plan) -> None:
        self._world = BulletWorld()
        self._world.set_gravity(Vec3(0, 0, 0))
        middle = (plan.left + plan.right) / 2, (plan.bottom + plan.top) / 2
        wide, deep = plan.right - plan.left, plan.top - plan.bottom
        for side in (-1, 1):
            self._fix_box(middle[0] + side * (wide / 2 + _THICK), middle[1], 2 * _THICK, deep + 4 * _THICK)
            self._fix_box(middle[0], middle[1] + side * (deep / 2 + _THICK), wide + 4 * _THICK, 2 * _THICK)
        for wall in plan.walls:
            across = (wall.left + wall.right) / 2, (wall.bottom + wall.top) / 2
            self._fix_box(*across, wall.right - wall.left, wall.top - wall.bottom)
        for piece in plan.furniture:
            self._fix_box(piece.x, piece.y, piece.width, piece.depth)
        for person in plan.persons:
            self._person(person.name).set_pos(person.place.x, person.place.y, _TALL / 2)
        self._visitor: NodePath | None = None
        body = BulletRigidBodyNode("robot")
        body.set_mass(_MASS)
        body.add_shape(BulletCylinderShape(RADIUS, _TALL, ZUp))
        body.set_linear_factor(Vec3(1, 1, 0))
        body.set_angular_factor(Vec3(0, 0, 0))
        body.set_friction(0.0)
        body.set_deactivation_enabled(False)
        self._body, self._path = body, NodePath(body)
        self._path.set_collide_mask(_ALL)
        self._world.attach(body)
        self._feeler = BulletCylinderShape(RADIUS - _HAIR, _TALL - 0.2, ZUp)
        self.put(plan.start.x, plan.start.y)

    def put(self, x: float, y: float) -> None:
        """Set the robot there; it stands."""
        self._path.set_pos(x, y, _TALL / 2)
        self._body.set_linear_velocity(Vec3(0, 0, 0))

    @property
    def at(self) -> tuple[float, float]:
        """Where the robot is, in metres."""
        position = self._path.get_pos()
        return float(position.x), float(position.y)

    def step(self, x: float, y: float) -> None:
        """Push the robot with this velocity (m/s) for one step."""
        self._body.set_linear_velocity(Vec3(x, y, 0))
        self._world.do_physics(STEP, 0, STEP)

    def room(self, x: float, y: float, most: float) -> float:
        """Return the metres that are free in a direction, up to `most`."""
        length = hypot(x, y)
        if not length:
            return most
        start = self._path.get_pos()
        # Bullet finds nothing where a body overlaps at the start: the feeler is slimmer than the robot.
        end = Point3(start.x + x / length * most, start.y + y / length * most, start.z)
        ahead = self._world.sweep_test_closest(
            self._feeler, TransformState.make_pos(start), TransformState.make_pos(end), _OTHERS
        )
        return most * float(ahead.get_hit_fraction()) if ahead.has_hit() else most

    def place_visitor(self, place: Place) -> None:
        """Set the walking visitor there, from the next step on."""
        if self._visitor is None:
            self._visitor = self._person("visitor")
            self._visitor.node().set_kinematic(True)
        self._visitor.set_pos(place.x, place.y, _TALL / 2)

    def _fix_box(self, x: float, y: float, wide: float, deep: float) -> None:
        node = BulletRigidBodyNode("fixed")
        node.add_shape(BulletBoxShape(Vec3(wide / 2, deep / 2, _TALL)))
        self._fix(node).set_pos(x, y, _TALL / 2)

    def _person(self, name: str) -> NodePath:
        node = BulletRigidBodyNode(name)
        node.add_shape(BulletCylinderShape(PERSON_RADIUS - 0.03, _TALL, ZUp))
        return self._fix(node)

    def _fix(self, node: BulletRigidBodyNode) -> NodePath:
        node.set_friction(0.0)
        path = NodePath(node)
        path.set_collide_mask(_ALL | _OTHERS)
        self._world.attach(node)
        return path
