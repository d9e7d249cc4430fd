"""The options that say what renders the avatar."""

import argparse
from collections.abc import Sequence

from openrois_avatar.picture_size import AUTOMATIC, SIZE_HELP, picture_size, size_text
from openrois_avatar.settings import DRAWN, ENGINES, AvatarSettings

__all__ = ["add_engine_options", "engine_arguments"]


def add_engine_options(parser: argparse.ArgumentParser) -> None:
    """Add `--engine` and what goes with it."""
    default = AvatarSettings().engine
    parser.add_argument("--engine", choices=ENGINES, default=default, help="what renders the avatar (%(default)s)")
    parser.add_argument(
        "--stamp",
        action="store_true",
        help="with --engine synthetic: write number and capture time into each picture, for measurements",
    )
    parser.add_argument("--size", type=picture_size, default=AUTOMATIC, metavar="WIDTHxHEIGHT", help=SIZE_HELP)
    parser.add_argument("--visitor", action="store_true", help="let a person walk about in the avatar's room")


def engine_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the same options for another command line.

    Raises:
        ValueError: they do not go together.
    """
    if chosen.stamp and chosen.engine != "synthetic":
        raise ValueError(f"--stamp: the pictures of {chosen.engine} are not stamped, only those of --engine synthetic")
    if chosen.engine not in DRAWN:
        _refuse_those_of_drawn(chosen)
    flags = tuple(f"--{name}" for name in ("stamp", "visitor") if getattr(chosen, name))
    return ("--engine", chosen.engine, "--size", size_text(chosen.size), *flags)


def _refuse_those_of_drawn(chosen: argparse.Namespace) -> None:
    """Refuse what only engines that draw the avatar in its room can do."""
    named = " or ".join(DRAWN[1:])
    if chosen.size is not None:
        raise ValueError(f"--size: {chosen.engine} has pictures of its own size; choose --engine {named}")
    if chosen.visitor:
        raise ValueError(f"--visitor: {chosen.engine} has no room for a visitor; choose --engine {named}")
