"""`openrois robot reachy`: run the adapter of a Reachy Mini until a signal stops it."""

from typing import Final

from openrois_robots.adapter.process import RobotCommand, run_hosted
from openrois_robots.reachy.adapter import hosted_reachy, linked_reachy
from openrois_robots.reachy.options import TABLES, add_options, read_settings

__all__ = ["COMMAND"]

COMMAND: Final = RobotCommand(
    "reachy",
    "A Reachy Mini behind a gateway.",
    "reachy",
    TABLES,
    add_options,
    read_settings,
    run_hosted(linked_reachy, hosted_reachy),
)
"""The command of a Reachy Mini."""
