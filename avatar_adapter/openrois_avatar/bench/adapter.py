"""The avatar adapter as it is measured, a process of its own: one video stream of colour bars, in a chosen size.

Run as `python -m openrois_avatar.bench.adapter GATEWAY WIDTH HEIGHT`.
"""

import sys
from typing import Final

import uvloop
from openrois_streaming.clock import SystemClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.publisher import VideoPublisher
from openrois_streaming.synthetic import ColourBars

from openrois.application import EngineHost
from openrois.dialer import serve_parent
from openrois.engine import Engine
from openrois.registry import LocalRegistry
from openrois.tasks import TaskScope
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_avatar.bench.partner import SWITCH_INTERVAL
from openrois_avatar.components.streaming import Streaming
from openrois_avatar.streams import AvatarStreams, Published

__all__ = ["COMPONENT_REF", "ENGINE_ID"]

ENGINE_ID: Final = "bench"
_COMPONENT: Final = "VideoStreaming"
COMPONENT_REF: Final = reference(ENGINE_ID, _COMPONENT)


async def _run(gateway: str, width: int, height: int) -> None:
    clock = SystemClock()
    video = VideoPublisher(ColourBars(width, height, clock=clock), clock=clock, stamp=True)
    codecs = tuple(codec for codec in available_codecs() if codec.startswith("video/"))
    streams = AvatarStreams(ENGINE_ID, {COMPONENT_REF: Published(video, "video")}, clock)
    component = Streaming(_COMPONENT, codecs, lambda: ComponentStatus.READY)
    engine = Engine(ENGINE_ID)
    async with TaskScope() as tasks, streams.sessions:
        await engine.attach(LocalRegistry(ENGINE_ID, [component], extension=streams))
        await serve_parent(EngineHost(engine, tasks), gateway)


if __name__ == "__main__":
    sys.setswitchinterval(SWITCH_INTERVAL)
    uvloop.run(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
