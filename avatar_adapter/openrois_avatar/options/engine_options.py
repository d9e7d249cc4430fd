"""The options of the engine that renders the avatar."""

import argparse
from collections.abc import Sequence

from openrois_avatar.options.picture_size import AUTOMATIC, SIZE_HELP, picture_size, size_text
from openrois_avatar.options.settings import DRAWN, ENGINES, AvatarSettings

__all__ = ["add_engine_options", "engine_arguments"]


def add_engine_options(parser: argparse.ArgumentParser) -> None:
    """Add `--engine`, `--stamp`, `--size` and `--visitor`."""
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
    """Return the options for another command line.

    Raises:
        ValueError: two options contradict each other.
    """
    if chosen.stamp and chosen.engine != "synthetic":
        raise ValueError(f"--stamp cannot be used with --engine {chosen.engine}, only with --engine synthetic")
    if chosen.engine not in DRAWN:
        _refuse_those_of_drawn(chosen)
    flags = tuple(f"--{name}" for name in ("stamp", "visitor") if getattr(chosen, name))
    return ("--engine", chosen.engine, "--size", size_text(chosen.size), *flags)


def _refuse_those_of_drawn(chosen: argparse.Namespace) -> None:
    """Refuse the options of engines that draw the avatar in its room."""
    named = " or ".join(DRAWN[1:])
    if chosen.size is not None:
        raise ValueError(f"--size cannot be used with --engine {chosen.engine}, only with {named}")
    if chosen.visitor:
        raise ValueError(f"--visitor cannot be used with --engine {chosen.engine}, only with {named}")
