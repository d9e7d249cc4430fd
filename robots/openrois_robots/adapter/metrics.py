"""Metrics that the adapter of every robot has."""

from typing import Final

from openrois_media.metrics.figures import FigureGroup

from openrois.metrics.figure import Figure
from openrois_robots.adapter.link import RobotLink

__all__ = ["LINK", "link_figures"]

LINK: Final[tuple[Figure[bool], ...]] = (
    Figure("openrois_robot_linked", "gauge", "Whether the robot has given its last sign of life.", float),
)


def link_figures(link: RobotLink) -> FigureGroup:
    """Return a copy of the figures of a link."""
    return FigureGroup(LINK, (), (((), link.is_up),))
