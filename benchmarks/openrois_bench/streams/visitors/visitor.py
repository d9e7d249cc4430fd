"""One visitor, a process of its own: a voice, and if wanted a talking head, encoded and sent to the body.

Run by `__main__` as `python -m openrois_bench.streams.visitors.visitor URL camera|microphone WIDTH HEIGHT FPS`.
"""

import asyncio
import itertools
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_media import Media
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio
from openrois_streaming.synthetic import TalkingHead

from openrois.client import Client
from openrois.jsonrpc.session import Handler
from openrois.types.codes import Purpose, StreamStatus
from openrois_bench.processes.partner import serve
from openrois_bench.viewing.adapter import ENGINE_ID

_BLOCK: Final = SAMPLE_RATE // 50
_SPOKEN: Final = 2.0
"""Seconds of the voice, which says the same again and again, with a second of silence between."""


class _Speaker:
    """A voice in blocks of 20 ms."""

    def __init__(self, clock: MediaClock) -> None:
        from tests.support.hearing import stereo_48k, voice  # a wheel has no tests

        said: NDArray[np.int16] = stereo_48k(voice(_SPOKEN))[:, :1]
        whole = np.concatenate([said, np.zeros((SAMPLE_RATE, 1), np.int16)])
        self._blocks = [whole[start : start + _BLOCK] for start in range(0, len(whole) - _BLOCK + 1, _BLOCK)]
        self._clock = clock

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        """Speak from now on."""
        yield self._due()

    async def _due(self) -> AsyncIterator[RawAudio]:
        began = self._clock.now()
        for number, samples in enumerate(itertools.cycle(self._blocks)):
            at = began + number * _BLOCK / SAMPLE_RATE
            await self._clock.sleep_until(at)
            yield RawAudio(samples, at)


@asynccontextmanager
async def _visiting(url: str, device: str, width: int, height: int, fps: float) -> AsyncIterator[Mapping[str, Handler]]:
    clock = SystemClock()
    head = TalkingHead(width, height, fps, clock=clock) if device == "camera" else None
    async with (
        Client(url, reconnect=None) as client,
        Media(client, clock=clock) as media,
        media.send(
            camera=head, microphone=_Speaker(clock), consent=[Purpose.LIVE, Purpose.RECOGNITION], to=ENGINE_ID
        ) as sending,
    ):

        async def run(_params: Mapping[str, Any]) -> None:
            """Answer when all that is sent arrives."""
            while {*sending.status.values()} != {StreamStatus.STREAMING_RUNNING}:  # noqa: ASYNC110 - it is not announced
                await asyncio.sleep(0.1)

        yield {"run": run}


if __name__ == "__main__":
    serve(partial(_visiting, sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), float(sys.argv[5])))
