"""The viewer without a browser, a process of its own: plays the stream as an application does and reads the stamps."""

import asyncio
import time
from collections.abc import Iterable, Mapping
from contextlib import nullcontext, suppress
from typing import Any, Final

from openrois_streaming.testing import SeenPicture

from openrois_bench.errors import BenchFailed
from openrois_bench.processes.partner import serve
from openrois_bench.viewing.application import Playing, application
from openrois_bench.viewing.observation import Order, Sightings

__all__ = ["watch"]

_QUIET: Final = 0.2
"""Seconds without a picture after which a stream has fallen silent."""
_FALLS_SILENT_WITHIN: Final = 5.0


async def watch(order: Order) -> Sightings:
    """Do what is ordered.

    Raises:
        BenchFailed: a request is refused, no picture comes, or a suspended stream goes on.
    """
    connects: list[float] = []
    while True:
        async with application(order.url) as app, app.playing(order.component_ref, order.codec) as playing:
            first = await playing.picture()
            connects.append(first.at - playing.asked_at)
            if len(connects) < order.runs:
                continue
            await _pictures(playing, order.settling)
            pictures = await _pictures(playing, order.seconds)
            # The pictures keep to a beat: resuming at other moments of it each time, no run repeats another.
            resumes = [await _resume(playing, run / order.resumes / order.fps) for run in range(order.resumes)]
        break
    stamped = [(picture.stamp, picture.wall) for picture in pictures if picture.stamp is not None]
    return Sightings(
        width=first.width,
        height=first.height,
        numbers=tuple(stamp.number for stamp, _ in stamped),
        unreadable=len(pictures) - len(stamped),
        milliseconds={
            "decoded": _milliseconds(stamp.age(wall) for stamp, wall in stamped),
            "connect": _milliseconds(connects),
        }
        | ({"resume": _milliseconds(resumes)} if resumes else {}),
    )


async def _pictures(playing: Playing, seconds: float) -> list[SeenPicture]:
    end = time.monotonic() + seconds
    pictures: list[SeenPicture] = []
    while time.monotonic() < end:
        pictures.append(await playing.picture())
    return pictures


async def _resume(playing: Playing, delay: float) -> float:
    """Suspend, and `delay` seconds after the last picture resume; the seconds until a picture made since then."""
    await playing.suspend()
    suspended = time.time()
    await _silence(playing)
    await asyncio.sleep(delay)
    asked_at = time.monotonic()
    await playing.resume()
    while True:
        picture = await playing.picture()
        # What was on its way when the stream was suspended is not new.
        if picture.stamp is not None and picture.stamp.age(suspended) < 0:
            return picture.at - asked_at


async def _silence(playing: Playing) -> None:
    deadline = time.monotonic() + _FALLS_SILENT_WITHIN
    with suppress(TimeoutError):
        while time.monotonic() < deadline:
            async with asyncio.timeout(_QUIET):
                await playing.picture()
        raise BenchFailed("a suspended stream goes on")


def _milliseconds(seconds: Iterable[float]) -> tuple[float, ...]:
    return tuple(round(value * 1000, 1) for value in seconds)


async def _watch(params: dict[str, Any]) -> Mapping[str, Any]:
    return (await watch(Order.model_validate(params))).model_dump(mode="json")


if __name__ == "__main__":
    serve(lambda: nullcontext({"watch": _watch}))
