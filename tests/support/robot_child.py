"""An adapter that tests kill and stop: `python -m tests.support.robot_child URL [ENGINE_ID]`."""

import sys
import time

from openrois.adapter import blocking, run
from openrois.component.authoring.marks import command
from tests.support.components import Bell, Lamp


class Blocking(Bell):
    """A bell with a command that keeps the whole adapter from doing anything else."""

    @command
    async def block(self, seconds: float) -> None:
        time.sleep(seconds)  # noqa: ASYNC251 - that is what this is for


if __name__ == "__main__":
    # What blocks is told of sooner than others have to be.
    blocking.told_of_blocking.__wrapped__.__defaults__ = (0.1,)  # type: ignore[attr-defined]
    run(Lamp(), Blocking("bell"), gateway=sys.argv[1], engine_id=(*sys.argv[2:], "robot")[0])
