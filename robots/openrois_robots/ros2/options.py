"""Settings of a robot that speaks ROS 2: its mapping file."""

import argparse
import os
from typing import Final

from openrois_robots.adapter.options import read_toml
from openrois_robots.ros2.mapping.reading import read_mapping
from openrois_robots.ros2.mapping.settings import RobotMapping, Ros

__all__ = ["TABLES", "add_options", "domain_of", "read_settings"]

TABLES: Final = (
    "ros, base, odometry, pose, battery, velocity, navigation, places, follow, camera and speech: the mapping"
)
"""The tables of the mapping file, for the help."""

_DOMAIN: Final = "ROS_DOMAIN_ID"


def add_options(_parser: argparse.ArgumentParser) -> None:
    """Add no options: everything about the robot is in its mapping file."""


def read_settings(chosen: argparse.Namespace) -> RobotMapping:
    """Return the mapping of the file.

    Raises:
        ValueError: there is none, or something in it is wrong; a sentence for a person.
    """
    if chosen.config is None:
        raise ValueError("--config is missing: it names the mapping file, which binds the robot's topics to components")
    document = read_toml(chosen.config)
    try:
        mapping = read_mapping(document)
        domain_of(mapping.ros)
    except ValueError as error:
        raise ValueError(f"--config: {chosen.config}: {error}") from None
    return mapping


def domain_of(ros: Ros) -> int:
    """Return the domain of the robot: that of the mapping file, else that of this process.

    Raises:
        ValueError: the environment has none that can be one.
    """
    if ros.domain >= 0:
        return ros.domain
    text = os.environ.get(_DOMAIN, "") or "0"
    if not text.isascii() or not text.isdigit() or int(text) > 232:
        raise ValueError(f"{_DOMAIN} must be between 0 and 232, not {text!r}; ros.domain is another place for it")
    return int(text)
