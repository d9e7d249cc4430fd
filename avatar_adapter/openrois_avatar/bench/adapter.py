"""The avatar adapter as it is measured, a process of its own: it serves the synthetic scene in a chosen size.

Run as `python -m openrois_avatar.bench.adapter GATEWAY WIDTH HEIGHT`.
"""

import sys
from typing import Final

import uvloop
from openrois_streaming.clock import SystemClock

from openrois.dialer import serve_parent
from openrois.types.references import reference
from openrois_avatar.adapter import VIDEO, serve_scene
from openrois_avatar.bench.partner import SWITCH_INTERVAL
from openrois_avatar.scene import synthetic_scene

__all__ = ["COMPONENT_REF", "ENGINE_ID"]

ENGINE_ID: Final = "bench"
COMPONENT_REF: Final = reference(ENGINE_ID, VIDEO)


async def _run(gateway: str, width: int, height: int) -> None:
    clock = SystemClock()
    async with serve_scene(ENGINE_ID, synthetic_scene(clock, width, height), clock) as avatar:
        await serve_parent(avatar.host, gateway)


if __name__ == "__main__":
    sys.setswitchinterval(SWITCH_INTERVAL)
    uvloop.run(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
