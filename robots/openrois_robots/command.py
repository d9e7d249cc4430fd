"""`openrois robot`: run a robot of this name until a signal stops it."""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from types import MappingProxyType
from typing import Final

from openrois.cli.command_line import CommandLine
from openrois.extras import MissingExtra, install_command, needing_extra

__all__ = ["ROBOTS", "main"]


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = CommandLine("openrois robot", description="A robot behind a gateway.")
    parser.add_argument("name", choices=tuple(ROBOTS), metavar="NAME", help=f"the robot: {', '.join(ROBOTS)}")
    chosen = parser.parse_args(arguments[:1])
    try:
        return ROBOTS[chosen.name](arguments[1:])
    except MissingExtra as error:
        print(f"openrois robot {chosen.name}: {error}", file=sys.stderr)
        return 1


def _simulated(arguments: Sequence[str]) -> int:
    with needing_extra("robot"):
        from openrois_robots.simulated.command import COMMAND
    return COMMAND.main(arguments)


def _ros2(arguments: Sequence[str]) -> int:
    with needing_extra("ros2"):
        from openrois_robots.ros2.command import COMMAND
    return COMMAND.main(arguments)


def _kachaka(arguments: Sequence[str]) -> int:
    if sys.version_info >= (3, 13) and find_spec("kachaka_api") is None:
        raise MissingExtra(
            "the Kachaka API needs Python 3.12 or older, and this is"
            f" {sys.version_info.major}.{sys.version_info.minor}: run `python3.12 -m venv kachaka` and"
            f" `kachaka/bin/{install_command('kachaka')}`, and start the robot with `kachaka/bin/openrois`"
        )
    with needing_extra("kachaka"):
        from openrois_robots.kachaka.command import COMMAND
    return COMMAND.main(arguments)


def _reachy(arguments: Sequence[str]) -> int:
    with needing_extra("reachy"):
        from openrois_robots.reachy.command import COMMAND
    return COMMAND.main(arguments)


ROBOTS: Final[Mapping[str, Callable[[Sequence[str]], int]]] = MappingProxyType(
    {"simulated": _simulated, "kachaka": _kachaka, "reachy": _reachy, "ros2": _ros2}
)
"""The robots, and the function that runs each; its libraries are imported then."""
