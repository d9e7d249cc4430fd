"""Sound of a microphone or a program as a source."""

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import AbstractAsyncContextManager, aclosing, asynccontextmanager
from typing import Any, Final, TypeAlias, cast

import av
import numpy as np
from numpy.typing import NDArray
from openrois_signaling.messages import MediaKind

from openrois_streaming.capture.given import check_function, is_source
from openrois_streaming.capture.iterated import Item, Items, IteratedSource
from openrois_streaming.capture.moments import SampleClock, capture_time
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import SAMPLE_RATE, MediaSource, RawAudio

Sound: TypeAlias = NDArray[np.int16] | tuple[NDArray[np.int16], float]
"""Samples, int16 of shape (n,) or (n, channels) with one or two channels, alone or with the moment of the first one, in
seconds of `time.monotonic()`."""

_BLOCKS: Final = 50
"""Blocks that may wait while the event loop is busy."""


class AudioSource:
    """Raw sound, a `MediaSource[RawAudio]`. It is opened while an application listens, and only then.

    Args:
        blocks: a function that returns an iterator of `Sound`, blocking or asynchronous, which has the pace of the
            microphone (blocks of 10 to 20 ms are best); or a `MediaSource[RawAudio]`, which is taken as it is.
        sample_rate: samples per second and channel; other rates than 48,000 are converted.
        clock: the media clock; this machine's if not given.
        name: its name in the log and in errors.

    Raises:
        TypeError: `blocks` is neither a function without arguments nor a source.
        ValueError: the rate is none of 8,000 to 192,000.
    """

    kind: Final[MediaKind] = "audio"

    def __init__(
        self,
        blocks: Items[Sound] | MediaSource[RawAudio],
        *,
        sample_rate: int = SAMPLE_RATE,
        clock: MediaClock | None = None,
        name: str = "microphone",
    ) -> None:
        if not isinstance(sample_rate, int) or not 8_000 <= sample_rate <= 192_000:
            raise ValueError(f"sample_rate of {name} must be 8000 to 192000, not {sample_rate}")
        self._rate = sample_rate
        self._name = name
        self._source: MediaSource[RawAudio] | IteratedSource[Sound]
        if is_source(blocks):
            self._source = cast("MediaSource[RawAudio]", blocks)
        else:
            check_function(blocks, name, "use piped_sound for a program that writes sound, such as arecord")
            items = cast("Items[Sound]", blocks)
            self._source = IteratedSource(items, clock=clock or SystemClock(), depth=_BLOCKS, name=name)

    def open(self) -> AbstractAsyncContextManager[AsyncIterator[RawAudio]]:
        """Open the microphone; its iterator raises what the microphone's raises.

        Raises:
            TypeError, ValueError: (the iterator) a block is no sound, or has no capture time.
        """
        source = self._source
        return self._read(source) if isinstance(source, IteratedSource) else source.open()

    @asynccontextmanager
    async def _read(self, source: IteratedSource[Sound]) -> AsyncIterator[AsyncIterator[RawAudio]]:
        async with source.open() as items, aclosing(self._converted(items)) as blocks:
            yield blocks

    async def _converted(self, items: AsyncIterator[Item[Sound]]) -> AsyncGenerator[RawAudio, None]:
        converter: Converter | None = None
        clock = SampleClock(self._rate)
        async for item in items:
            block, captured_at = capture_time(item.value, item.came_at, self._name)
            samples = _samples(block, self._name)
            if not isinstance(item.value, tuple):
                captured_at = clock.began(len(samples), item.came_at)
            if self._rate == SAMPLE_RATE:
                yield RawAudio(samples, captured_at)
                continue
            if converter is None or converter.channels != samples.shape[1]:
                converter = Converter(self._rate, samples.shape[1])
            if len(converted := converter.convert(samples)):
                yield RawAudio(converted, captured_at)


class Converter:
    """Converter of sound from another rate to 48,000 samples per second. Some samples wait for those after them.

    Args:
        rate: samples per second of the input.
        channels: 1 or 2.
    """

    def __init__(self, rate: int, channels: int) -> None:
        self.channels = channels
        self._rate = rate
        self._layout = "mono" if channels == 1 else "stereo"
        self._resampler = av.AudioResampler("s16", self._layout, SAMPLE_RATE)

    def convert(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Convert int16 of shape (n, channels); the result has about n * 48,000 / rate samples."""
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples).reshape(1, -1), "s16", self._layout)
        frame.sample_rate = self._rate
        made = [each.to_ndarray().reshape(-1, self.channels) for each in self._resampler.resample(frame)]
        return np.concatenate([np.empty((0, self.channels), np.int16), *made]).astype(np.int16, copy=False)


def _samples(block: Any, name: str) -> NDArray[np.int16]:
    if not isinstance(block, np.ndarray) or block.dtype != np.int16:
        found = block.dtype if isinstance(block, np.ndarray) else type(block).__name__
        raise TypeError(f"{name} must yield sound as int16 arrays, not {found}: scale floats by 32767 first")
    if block.ndim == 1:
        return block[:, np.newaxis]
    if block.ndim != 2 or block.shape[1] not in (1, 2):
        raise ValueError(f"{name} must yield sound of shape (n,), (n, 1) or (n, 2), not {block.shape}")
    return block
