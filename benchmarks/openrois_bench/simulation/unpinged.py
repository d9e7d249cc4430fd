"""`openrois gateway` without pings, which would take more than what is measured and come in clumps."""

import sys
from dataclasses import replace
from functools import partial
from typing import Final
from unittest.mock import patch

from openrois.gateway import command
from openrois.gateway.server import run_gateway
from openrois.gateway.socket import ADAPTER, APPLICATION, SocketProfile

NEVER: Final = 86_400.0
"""Seconds between pings: more than any measurement takes."""


def _unpinged(profile: SocketProfile) -> SocketProfile:
    return replace(profile, ping_interval=NEVER)


def main() -> int:
    """Run the gateway with the arguments of its command, and return its exit status."""
    running = partial(run_gateway, application=_unpinged(APPLICATION), adapter=_unpinged(ADAPTER))
    with patch.object(command, "run_gateway", running):
        return command.main(sys.argv[1:])


if __name__ == "__main__":
    raise SystemExit(main())
