"""Metrics of a Reachy Mini: its link and its motions."""

from dataclasses import replace
from typing import Final

from openrois_media.metrics.figures import FigureGroup

from openrois.metrics.figure import Figure
from openrois_robots.adapter.link import RobotLink
from openrois_robots.adapter.metrics import link_figures
from openrois_robots.reachy.motion import MotionFigures

__all__ = ["MOTION", "reachy_figures"]

MOTION: Final[tuple[Figure[MotionFigures], ...]] = (
    Figure("openrois_robot_targets_total", "counter", "Targets sent to the robot, 50 a second.", lambda m: m.targets),
    Figure("openrois_robot_stops_total", "counter", "Calls of the robot's own stop.", lambda m: m.stops),
    Figure(
        "openrois_robot_unfollowed_total",
        "counter",
        "Motions that ended because the robot did not follow its targets.",
        lambda m: m.unfollowed,
    ),
)


def reachy_figures(link: RobotLink, motion: MotionFigures) -> tuple[FigureGroup, ...]:
    """Return a copy of the figures."""
    return (link_figures(link), FigureGroup(MOTION, (), (((), replace(motion)),)))
