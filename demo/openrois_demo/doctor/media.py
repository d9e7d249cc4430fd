"""A trial of media: a few pictures and sounds from an engine to a viewer, and a key back, all in this process."""

import asyncio
import time
from collections.abc import Sequence
from typing import Final

from openrois_signaling.messages import IceServer
from openrois_streaming.clock import SystemClock
from openrois_streaming.input.messages import Key
from openrois_streaming.input.reader import Label
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.synthetic import ColourBars, Tone
from openrois_streaming.testing.pictures import PictureFigures
from openrois_streaming.testing.sink import MeasuringSink
from openrois_streaming.testing.stage import playing

from openrois_demo.doctor.finding import Finding, Level

__all__ = ["media"]

_PICTURES: Final = 30
_TIMEOUT: Final = 10.0
_LATE: Final = 0.2


class _Keys:
    """Waits for a key of the viewer."""

    def __init__(self) -> None:
        self.came = asyncio.Event()

    def input_came(self, _label: Label, _data: str | bytes) -> None:
        self.came.set()

    def input_lost(self, _reason: str) -> None:
        """Ignore the end of the channel."""


async def media(settings: NetworkSettings, servers: Sequence[IceServer]) -> list[Finding]:
    """Play to a viewer in this process, with these settings, over the servers where media needs them."""
    clock = SystemClock()
    video = VideoPublisher(ColourBars(640, 360, clock=clock), clock=clock, stamp=True)
    audio = AudioPublisher(Tone(clock=clock), clock=clock)
    began, keys, typed = time.monotonic(), _Keys(), None
    try:
        async with (
            asyncio.timeout(_TIMEOUT) as limit,
            MeasuringSink(clock=clock) as sink,
            playing(sink, video=video, audio=audio, network=settings, ice_servers=servers, inputs=keys),
        ):
            await sink.sees(1)
            first = time.monotonic() - began
            await sink.sees(_PICTURES)
            seen = sink.pictures()
            limit.reschedule(None)  # a key has a limit of its own
            typed = await _type(sink, keys)
    except Exception as error:  # whatever it is, it is what a viewer would have met
        advice = "The lines above may say why; a firewall on this machine can block its own UDP too."
        return [Finding(Level.FAIL, "media", f"no pictures within {_TIMEOUT:.0f} s ({_said(error)})", advice)]
    return [_seen(seen, first), _typed(typed)]


async def _type(sink: MeasuringSink, keys: _Keys) -> float | None:
    """Return the seconds until a key of the viewer arrived; None where it did not."""
    try:
        async with asyncio.timeout(_TIMEOUT):
            await sink.until(lambda: sink.input is not None and sink.input.are_open)
            began = time.monotonic()
            if sink.input is not None:
                sink.input.send_message(Key(1, 0.0, "KeyW", True))
            await keys.came.wait()
            return time.monotonic() - began
    except TimeoutError:
        return None


def _typed(seconds: float | None) -> Finding:
    if seconds is not None:
        return Finding(Level.OK, "input", f"a key was there after {1000 * seconds:.0f} ms")
    advice = "Streams work without, but no visitor can operate a figure by hand."
    return Finding(Level.WARN, "input", "no key came over the data channels", advice)


def _seen(seen: PictureFigures, first: float) -> Finding:
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
