"""The options that say what renders the avatar."""

import argparse
from collections.abc import Sequence

from openrois_avatar.settings import ENGINES, AvatarSettings

__all__ = ["add_engine_options", "engine_arguments"]


def add_engine_options(parser: argparse.ArgumentParser) -> None:
    """Add `--engine` and `--stamp`."""
    default = AvatarSettings().engine
    parser.add_argument("--engine", choices=ENGINES, default=default, help="what renders the avatar (%(default)s)")
    parser.add_argument(
        "--stamp",
        action="store_true",
        help="with --engine synthetic: write number and capture time into each picture, for measurements",
    )


def engine_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the same options for another command line.

    Raises:
        ValueError: they do not go together.
    """
    if chosen.stamp and chosen.engine != "synthetic":
        raise ValueError(f"--stamp: the pictures of {chosen.engine} are not stamped, only those of --engine synthetic")
    return ("--engine", chosen.engine, *(("--stamp",) if chosen.stamp else ()))
