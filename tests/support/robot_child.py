"""An adapter that tests kill and stop: `python -m tests.support.robot_child URL [ENGINE_ID]`."""

import sys
import time

from openrois.adapter import run
from openrois.authoring.marks import command
from tests.support.components import Bell, Lamp


class Blocking(Bell):
    """A bell with a command that keeps the whole adapter from doing anything else."""

    @command
    async def block(self, seconds: float) -> None:
        time.sleep(seconds)  # noqa: ASYNC251 - that is what this is for


if __name__ == "__main__":
    run(Lamp(), Blocking("bell"), gateway=sys.argv[1], engine_id=(*sys.argv[2:], "robot")[0])
