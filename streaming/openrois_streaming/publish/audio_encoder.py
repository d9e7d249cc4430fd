"""Opus for live sound: packets of 20 ms whose times follow the samples, not the jitter of their delivery."""

from fractions import Fraction
from typing import cast

import av
import numpy as np
from av.audio.codeccontext import AudioCodecContext
from numpy.typing import NDArray

from openrois_streaming.codecs import LIBRARIES, OPUS
from openrois_streaming.encoded import AUDIO_CLOCK_RATE
from openrois_streaming.publish.encoder import Chunk
from openrois_streaming.rtp.payloads import payloads_of
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

MIN_AUDIO_BITRATE = 6_000
MAX_AUDIO_BITRATE = 510_000
"""Bounds of an Opus rendition in bit/s (RFC 6716 section 2.1.1)."""

SAMPLES_PER_PACKET = SAMPLE_RATE // 50

# How far, in samples, the sound may be from its capture times before the packets' times are set anew. Less is the
# jitter of the source, or a drift of its sample clock that a receiver evens out by itself. As much as a block of 20 ms
# is one that was lost: without a gap in its place, all sound after it would come too early for its pictures.
_TOLERANCE = SAMPLE_RATE * 15 // 1000
_TIME_BASE = Fraction(1, AUDIO_CLOCK_RATE)


class OpusEncoder:
    """Encodes blocks of any length, mono or stereo, into packets of 20 ms.

    Sound that is missing leaves a gap in the packets' times. Sound that comes ahead of its time, from a source whose
    sample clock is too fast, is left out until the times agree again. A change between mono and stereo starts the codec
    anew.

    The codec looks ahead: a packet plays samples captured a little before those encoded with it (6.5 ms, RFC 7845
    section 4.2), and its `captured_at` says so. Otherwise sound would lag behind the lips by that time.
    """

    def __init__(self, *, bitrate: int) -> None:
        self._bitrate = audio_within_bounds(bitrate)
        self._context: AudioCodecContext | None = None
        self._layout = ""
        self._pending: NDArray[np.int16] = np.empty((0, 1), np.int16)
        self._pts: int | None = None
        """Time of the first pending sample."""

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s), kept within MIN_AUDIO_BITRATE and MAX_AUDIO_BITRATE, from the next packet on."""
        self._bitrate = audio_within_bounds(bitrate)
        self._context = None

    def encode(self, raw: RawAudio, *, key_frame: bool) -> list[Chunk]:
        """Encode the packets that this block completes. `key_frame` means nothing here: each packet stands alone.

        Raises:
            av.FFmpegError: the codec cannot be opened, or has failed.
        """
        pts = self._take_in(raw)
        chunks: list[Chunk] = []
        while len(self._pending) >= SAMPLES_PER_PACKET:
            block, self._pending = self._pending[:SAMPLES_PER_PACKET], self._pending[SAMPLES_PER_PACKET:]
            chunks += self._encode_packet(block, pts)
            pts += SAMPLES_PER_PACKET
        self._pts = pts
        return chunks

    def _take_in(self, raw: RawAudio) -> int:
        """Add the block to the pending samples; returns the time of the first one."""
        arrival = round(raw.captured_at * SAMPLE_RATE)
        if self._pts is None or raw.samples.shape[1] != self._pending.shape[1]:
            self._pending = raw.samples
            return max(arrival, self._pts or 0)
        ahead = self._pts + len(self._pending) - arrival
        if ahead < -_TOLERANCE:
            self._pending = raw.samples
            return arrival
        if ahead <= _TOLERANCE:
            self._pending = np.concatenate((self._pending, raw.samples))
        return self._pts

    def _encode_packet(self, block: NDArray[np.int16], pts: int) -> list[Chunk]:
        layout = "mono" if block.shape[1] == 1 else "stereo"
        if self._context is None or layout != self._layout:
            self._context = _open(layout, self._bitrate)
            self._layout = layout
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(block).reshape(1, -1), format="s16", layout=layout)
        frame.sample_rate, frame.pts, frame.time_base = SAMPLE_RATE, pts, _TIME_BASE
        packets = [bytes(packet) for packet in self._context.encode(frame)]
        captured_at = (pts - _look_ahead(self._context)) / SAMPLE_RATE
        return [Chunk(data, pts, True, captured_at, payloads_of(OPUS, data)) for data in packets]


def audio_within_bounds(bitrate: int) -> int:
    """Return `bitrate`, or the nearest one that an Opus rendition can have."""
    return max(MIN_AUDIO_BITRATE, min(bitrate, MAX_AUDIO_BITRATE))


def _look_ahead(context: AudioCodecContext) -> int:
    """Return the samples by which the decoder lags behind the input: the pre-skip of the codec's own header."""
    header = context.extradata or b""
    return int.from_bytes(header[10:12], "little")


def _open(layout: str, bitrate: int) -> AudioCodecContext:
    context = cast(AudioCodecContext, av.CodecContext.create(LIBRARIES[OPUS], "w"))
    context.format, context.layout, context.sample_rate = "s16", layout, SAMPLE_RATE
    context.bit_rate = bitrate
    context.time_base = _TIME_BASE
    context.options = {"application": "audio", "frame_duration": "20"}
    context.open()
    return context
