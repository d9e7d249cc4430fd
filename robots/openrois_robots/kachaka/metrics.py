"""Metrics of a Kachaka: its link, commands, velocities and cameras."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Final

from openrois_media.metrics.figures import FigureGroup

from openrois.metrics.figure import Figure
from openrois_robots.adapter.link import RobotLink
from openrois_robots.adapter.metrics import link_figures
from openrois_robots.kachaka.api.commands import CommandFigures
from openrois_robots.kachaka.camera import CameraFigures
from openrois_robots.kachaka.driver import DriveFigures

__all__ = ["CAMERA", "CAMERA_LABELS", "COMMAND", "OUTCOMES", "VELOCITY", "kachaka_figures"]

OUTCOMES: Final = ("outcome",)
CAMERA_LABELS: Final = ("camera",)
"""Labels of the figures."""

COMMAND: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_robot_commands_total",
        "counter",
        "Commands of this adapter at the robot: begun, cancelled, and lost: without a result that was told.",
        lambda count: count,
    ),
)
VELOCITY: Final[tuple[Figure[int], ...]] = (
    Figure(
        "openrois_robot_velocities_total",
        "counter",
        "Velocities by hand that the robot has taken (sent), and those that it has not (failed).",
        lambda count: count,
    ),
)
CAMERA: Final[tuple[Figure[CameraFigures], ...]] = (
    Figure("openrois_robot_pictures_total", "counter", "Pictures fetched from the robot.", lambda c: c.fetched),
    Figure(
        "openrois_robot_pictures_unreadable_total",
        "counter",
        "Of them those that are no pictures.",
        lambda c: c.unreadable,
    ),
)


def kachaka_figures(
    link: RobotLink, commands: CommandFigures, driving: DriveFigures, cameras: Mapping[str, CameraFigures]
) -> tuple[FigureGroup, ...]:
    """Return a copy of the figures."""
    return (
        link_figures(link),
        FigureGroup(COMMAND, OUTCOMES, tuple(((name,), n) for name, n in asdict(commands).items())),
        FigureGroup(VELOCITY, OUTCOMES, tuple(((name,), n) for name, n in asdict(driving).items())),
        FigureGroup(CAMERA, CAMERA_LABELS, tuple(((name,), replace(each)) for name, each in cameras.items())),
    )
