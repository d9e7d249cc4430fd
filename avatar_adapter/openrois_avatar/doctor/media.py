"""Whether media passes: a few pictures and sounds from an engine to a viewer, both in this process."""

import asyncio
import time
from collections.abc import Sequence
from typing import Final

from openrois_signaling.messages import IceServer
from openrois_streaming.clock import SystemClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.synthetic import ColourBars, Tone
from openrois_streaming.testing.sink import MeasuringSink
from openrois_streaming.testing.stage import playing

from openrois_avatar.doctor.finding import Finding, Level

__all__ = ["media"]

_PICTURES: Final = 30
_TIMEOUT: Final = 10.0
_LATE: Final = 0.2


async def media(settings: NetworkSettings, servers: Sequence[IceServer]) -> Finding:
    """Play to a viewer of our own, as the settings have it and over the servers if it needs them."""
    clock = SystemClock()
    video = VideoPublisher(ColourBars(640, 360, clock=clock), clock=clock, stamp=True)
    audio = AudioPublisher(Tone(clock=clock), clock=clock)
    began = time.monotonic()
    try:
        async with (
            asyncio.timeout(_TIMEOUT),
            MeasuringSink(clock=clock) as sink,
            playing(sink, video=video, audio=audio, network=settings, ice_servers=servers),
        ):
            await sink.sees(1)
            first = time.monotonic() - began
            await sink.sees(_PICTURES)
            seen = sink.pictures()
    except Exception as error:  # whatever it is, it is what a viewer would have met
        advice = "The lines above may say why; a firewall on this machine can block its own UDP too."
        return Finding(Level.FAIL, "media", f"no pictures within {_TIMEOUT:.0f} s ({_said(error)})", advice)
    median = None if seen.delay is None else seen.delay.p50
    told = f"first picture after {1000 * first:.0f} ms, then {seen.pictures} with {seen.missed} missed"
    if median is None:
        return Finding(Level.WARN, "media", told, "The pictures arrive, but what is written in them cannot be read.")
    told += f", {1000 * median:.0f} ms from capture to decoded"
    if median > _LATE:
        return Finding(Level.WARN, "media", told, "This machine is too busy for live pictures; see its load.")
    return Finding(Level.OK, "media", told)


def _said(error: BaseException) -> str:
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return str(error) or type(error).__name__
