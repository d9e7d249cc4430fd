"""The avatar adapter as it is measured, a process of its own: the synthetic scene, and a wheel that turns.

Run as `python -m openrois_bench.viewing.adapter GATEWAY WIDTH HEIGHT FPS bars|head`.
"""

import asyncio
import sys
import time
from dataclasses import replace
from typing import Final, Literal

import uvloop
from openrois_avatar.adapter import AUDIO, VIDEO, serve_scene
from openrois_avatar.scene import synthetic_scene
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import TalkingHead

from openrois.adapter import Component, command
from openrois.adapter.dialer import serve_parent
from openrois.types.references import reference
from openrois_bench.processes.partner import SWITCH_INTERVAL

__all__ = ["COMPONENT_REF", "ENGINE_ID", "SOUND_REF", "STOPPED", "WHEEL_REF", "Show"]

ENGINE_ID: Final = "bench"
COMPONENT_REF: Final = reference(ENGINE_ID, VIDEO)
SOUND_REF: Final = reference(ENGINE_ID, AUDIO)
WHEEL_REF: Final = reference(ENGINE_ID, "wheel")

STOPPED: Final = "stopped "
"""What the adapter prints when the wheel has stopped, before the time of this machine's monotonic clock."""

Show = Literal["bars", "head"]
"""Colour bars, or a talking head, which fills a bit rate as a camera does."""


class Wheel(Component, authority="OpenRoIS", function="actuation"):
    """Turns until it is stopped."""

    dead_man = 0.5

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._stopped = asyncio.Event()

    @command
    async def start(self) -> None:
        """Turn."""
        self._stopped.clear()
        await self._stopped.wait()

    @command
    async def stop(self) -> None:
        """Turn no more."""
        self._stopped.set()
        print(f"{STOPPED}{time.monotonic()}", flush=True)


async def _run(gateway: str, width: int, height: int, fps: float, show: str) -> None:
    clock = SystemClock()
    scene = replace(synthetic_scene(clock, width, height, fps, stamped=True), components=(Wheel("wheel"),))
    if show == "head":
        scene = replace(scene, video=TalkingHead(width, height, fps, clock=clock))
    async with serve_scene(ENGINE_ID, scene, clock) as avatar:
        await serve_parent(avatar.host, gateway)


if __name__ == "__main__":
    sys.setswitchinterval(SWITCH_INTERVAL)
    uvloop.run(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]), sys.argv[5]))
