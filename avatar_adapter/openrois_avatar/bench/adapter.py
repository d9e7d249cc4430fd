"""The avatar adapter as it is measured, a process of its own: it serves the synthetic scene as it is told.

Run as `python -m openrois_avatar.bench.adapter GATEWAY WIDTH HEIGHT FPS bars|head`.
"""

import sys
from dataclasses import replace
from typing import Final, Literal

import uvloop
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import TalkingHead

from openrois.dialer import serve_parent
from openrois.types.references import reference
from openrois_avatar.adapter import AUDIO, VIDEO, serve_scene
from openrois_avatar.bench.partner import SWITCH_INTERVAL
from openrois_avatar.scene import synthetic_scene

__all__ = ["COMPONENT_REF", "ENGINE_ID", "SOUND_REF", "Show"]

ENGINE_ID: Final = "bench"
COMPONENT_REF: Final = reference(ENGINE_ID, VIDEO)
SOUND_REF: Final = reference(ENGINE_ID, AUDIO)

Show = Literal["bars", "head"]
"""Colour bars, or a talking head, which fills a bit rate as a camera does."""


async def _run(gateway: str, width: int, height: int, fps: float, show: str) -> None:
    clock = SystemClock()
    scene = synthetic_scene(clock, width, height, fps, stamped=True)
    if show == "head":
        scene = replace(scene, video=TalkingHead(width, height, fps, clock=clock))
    async with serve_scene(ENGINE_ID, scene, clock) as avatar:
        await serve_parent(avatar.host, gateway)


if __name__ == "__main__":
    sys.setswitchinterval(SWITCH_INTERVAL)
    uvloop.run(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]), sys.argv[5]))
