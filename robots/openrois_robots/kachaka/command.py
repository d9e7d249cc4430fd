"""`openrois robot kachaka`: run the adapter of a Kachaka until a signal stops it."""

from typing import Final

from openrois_robots.adapter.process import RobotCommand, run_hosted
from openrois_robots.kachaka.adapter import hosted_kachaka, linked_kachaka
from openrois_robots.kachaka.options import TABLES, add_options, read_settings

__all__ = ["COMMAND"]

COMMAND: Final = RobotCommand(
    "kachaka",
    "A Kachaka behind a gateway.",
    "kachaka",
    TABLES,
    add_options,
    read_settings,
    run_hosted(linked_kachaka, hosted_kachaka),
)
"""The command of a Kachaka."""
